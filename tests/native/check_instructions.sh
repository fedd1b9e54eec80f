#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# check_instructions OBJDUMP NM ISA OBJECT...  fails if objects compiled for an instruction set of x86-64 do not run on
# every processor that has it:
#   - baseline must not use AVX, avx2 must not use AVX-512;
#   - avx2 and avx512 must not define symbols outside of the namespace arap::ISA: the linker keeps one copy of an inline
#     function that objects share, and that copy must run everywhere.
set -eu

objdump=$1
nm=$2
isa=$3
shift 3
[ $# -gt 0 ] || { echo "check_instructions: no objects given" >&2 && exit 2; }

case $isa in
  baseline) foreign='[[:space:]]v[a-z0-9]+[[:space:]]|%[yz]mm' ;;
  avx2) foreign='%zmm|%k[0-7]|%[xy]mm(1[6-9]|2[0-9]|3[01])' ;;
  avx512) foreign='^$' ;; # none is newer
  *) echo "check_instructions: no instruction set $isa" >&2 && exit 2 ;;
esac

failed=0
for object in "$@"; do
  "$objdump" -d --no-show-raw-insn "$object" >/dev/null # fails if it cannot read the object
  found=$("$objdump" -d --no-show-raw-insn "$object" | grep '^ ' | grep -E "$foreign" | head -n 3 || true)
  if [ -n "$found" ]; then
    printf '%s has instructions beyond %s:\n%s\n' "$object" "$isa" "$found"
    failed=1
  fi
  [ "$isa" != baseline ] || continue
  found=$("$nm" --demangle --defined-only --extern-only "$object" | grep '^[0-9a-f]' | grep -v " arap::$isa::" || true)
  if [ -n "$found" ]; then
    printf '%s shares functions with objects for other instruction sets:\n%s\n' "$object" "$found"
    failed=1
  fi
done
exit $failed
