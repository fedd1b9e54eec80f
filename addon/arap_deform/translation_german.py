# SPDX-License-Identifier: GPL-3.0-or-later
"""German. What is missing here stays English; tests see to it that each text is still one of the add-on's."""

MESSAGES = {
    "First Pose": "Erste Pose",
    "Select the mesh": "Das Mesh auswählen",
    "Enter Edit Mode": "In den Edit-Modus gehen",
    "Pin what stays": "Festhalten, was bleibt",
    "Add a handle": "Einen Griff setzen",
    "Leave Edit Mode": "Den Edit-Modus verlassen",
    "Pins": "Fixpunkte",
    "Handles": "Griffe",
    "Pose": "Posieren",
    "Pull": "Ziehen",
    "Solve": "Lösen",
    "Live": "Live",
    "Bake": "Backen",
    "Bake Pose": "Pose backen",
    "Bake Animation": "Animation backen",
    "Reset Pose": "Pose zurücksetzen",
    "Reset Handles": "Griffe zurücksetzen",
    "Apply Pose as Rest": "Pose als Ruheform übernehmen",
    "Pin Selected Vertices": "Ausgewählte Punkte festhalten",
    "Add from Selected Vertices": "Aus ausgewählten Punkten",
    "Add from Selected Empties": "Aus ausgewählten Empties",
    "Select Them": "Auswählen",
    "Keep (Enter)": "Behalten (Enter)",
    "Cancel (Esc)": "Abbrechen (Esc)",
    "Preparing the mesh: {:.0%}": "Das Mesh wird vorbereitet: {:.0%}",
    "Following the handles": "Folgt den Griffen",
    "Settled": "Zur Ruhe gekommen",
    "Held by nothing, so they stay at rest: {} parts of the mesh": (
        "Von nichts gehalten, also in Ruhe: {} Teile des Meshs"
    ),
    "1 iteration": "1 Schritt",
    "{} iterations": "{} Schritten",
    "Solved in {}, {:.0f} ms": "Gelöst in {}, {:.0f} ms",
    "Baked shape keys '{}' to '{}': {}": "Shape Keys '{}' bis '{}' gebacken: {}",
    "1 key": "1 Key",
    "{} keys": "{} Keys",
    "{} keys for {} frames, off by {:.3f} % of the size at most": (
        "{} Keys für {} Bilder, höchstens {:.3f} % der Größe daneben"
    ),
    "{}, {} in the file, {} in memory": "{}, {} in der Datei, {} im Speicher",
    "At most {}": "Höchstens {}",
    "Off by at most {}": "Höchstens {} daneben",
    "Not every handle took part; {}": "Nicht jeder Griff war dabei; {}",
    "not there any more or unusable: {}": "nicht mehr da oder unbrauchbar: {}",
    "not in the pose, so left where they are: {}": "nicht in der Pose, also geblieben, wo sie sind: {}",
    "held by animation, a constraint, a driver or a sheared parent: {}": (
        "von Animation, einem Constraint, einem Treiber oder einem gescherten Parent gehalten: {}"
    ),
    "Select a mesh first": "Zuerst ein Mesh auswählen",
    "Go to Object Mode first (Tab)": "Zuerst in den Objekt-Modus gehen (Tab)",
    "Add a handle first: nothing moves the mesh yet": "Zuerst einen Griff setzen: noch bewegt nichts das Mesh",
    "There is no pose yet: press Pose or Solve first": "Es gibt noch keine Pose: zuerst Posieren oder Lösen",
}
