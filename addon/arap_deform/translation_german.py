# SPDX-License-Identifier: GPL-3.0-or-later
"""German: all that the tab says; the rest stays English. Tests see to it that each text is still one of the add-on's.

Short words where a button has little room: at normal scale no text of the tab is cut.
"""

MESSAGES = {
    # The first pose
    "First Pose": "Erste Pose",
    "Select the mesh": "Das Mesh auswählen",
    "Click it in the view, or add one (Shift A).": "In der Ansicht anklicken, oder eins hinzufügen (Umschalt A).",
    "Enter Edit Mode": "Bearbeitungsmodus",
    "Or press Tab. Vertices are selected there.": "Oder Tab drücken. Dort werden Punkte ausgewählt.",
    "Pin what stays": "Festhalten, was bleibt",
    "First select its vertices, those of a foot for example.": (
        "Zuerst dessen Punkte auswählen, zum Beispiel die eines Fußes."
    ),
    "All vertices are selected now. Drag a box around those that shall stay, a foot for example.": (
        "Jetzt sind alle Punkte ausgewählt. Ein Rechteck um die ziehen, die bleiben sollen, zum Beispiel einen Fuß."
    ),
    "Add a handle": "Einen Griff setzen",
    "First select the vertices that shall move, those of a hand for example. An empty appears there.": (
        "Zuerst die Punkte auswählen, die sich bewegen sollen, zum Beispiel die einer Hand. Dort erscheint ein Empty."
    ),
    "Leave Edit Mode": "Zum Objektmodus",
    "Or press Tab. The mesh is posed in Object Mode.": "Oder Tab drücken. Dort wird das Mesh posiert.",
    "Go to Object Mode": "Zum Objektmodus",
    "Or choose it in the menu at the top left of the view. The mesh is posed there.": (
        "Oder ihn im Menü oben links in der Ansicht wählen. Dort wird das Mesh posiert."
    ),
    "Pose": "Posieren",
    "Then click the empty and move it (G): the mesh follows.": (
        "Dann das Empty anklicken und bewegen (G): das Mesh folgt."
    ),
    "Move the empty": "Das Empty bewegen",
    "Click it and press G: the mesh follows. Enter keeps the pose.": (
        "Anklicken und G drücken: das Mesh folgt. Enter behält die Pose."
    ),
    # Pins, handles, stiffness
    "Pins": "Fixpunkte",
    "Pin Selected Vertices": "Auswahl festhalten",
    "Pin Vertex Group": "Gruppe festhalten",
    "no such group": "keine solche Gruppe",
    "no weights": "ohne Gewichte",
    "Paint": "Malen",
    "Select": "Wählen",
    "Soften": "Weich",
    "Handles": "Griffe",
    "Exact": "Exakt",
    "In Front": "Vorn",
    "Add from Selected Vertices": "Aus ausgewählten Punkten",
    "Add from Selected Empties": "Aus ausgewählten Empties",
    "Stiffness": "Steifheit",
    "Rigid": "Starr",
    "One Body": "Ein Körper",
    "Make Selected Rigid": "Auswahl starr machen",
    "Stiffen Selected Vertices": "Auswahl versteifen",
    "Stiffen Vertex Group": "Gruppe versteifen",
    "New Group to Paint": "Neue Gruppe zum Malen",
    # Posing
    "Pull": "Ziehen",
    "Solve": "Lösen",
    "Reset Pose": "Pose zurücksetzen",
    "Reset Handles": "Griffe zurücksetzen",
    "Apply Pose as Rest": "Pose als Ruheform",
    "Keep (Enter)": "Behalten (Enter)",
    "Cancel (Esc)": "Abbrechen (Esc)",
    "Preparing: {:.0%}": "Vorbereitung: {:.0%}",
    "Following the handles": "Folgt den Griffen",
    "Settled": "Zur Ruhe gekommen",
    "Move, turn or scale a handle (G, R, S): the mesh follows.": (
        "Einen Griff bewegen, drehen oder skalieren (G, R, S): das Mesh folgt."
    ),
    "Select Them": "Auswählen",
    "Held by nothing, so it stays at rest: 1 part of the mesh": "Von nichts gehalten, also in Ruhe: 1 Teil des Meshs",
    "Held by nothing, so they stay at rest: {} parts of the mesh": (
        "Von nichts gehalten, also in Ruhe: {} Teile des Meshs"
    ),
    "Held by nothing, so they stay at rest: {} parts and {} loose vertices": (
        "Von nichts gehalten, also in Ruhe: {} Teile und {} lose Punkte"
    ),
    "In no face, so it stays at rest: 1 loose vertex": "In keiner Fläche, also in Ruhe: 1 loser Punkt",
    "In no face, so they stay at rest: {} loose vertices": "In keiner Fläche, also in Ruhe: {} lose Punkte",
    "Last Solve": "Letzte Lösung",
    "Vertices": "Punkte",
    "Free": "Frei",
    "Last update": "Zuletzt",
    "Iterations": "Schritte",
    "Energy": "Energie",
    "Stopped": "Ende",
    "Converged": "Am Ziel",
    "Iteration limit": "Schrittgrenze",
    "Time limit": "Zeitgrenze",
    # Live
    "Live": "Live",
    "Tick Live and the mesh follows its handles all the time, also in playback": (
        "Mit Häkchen folgt das Mesh seinen Griffen ständig, auch beim Abspielen"
    ),
    "Untick Live to stop": "Zum Anhalten das Häkchen wegnehmen",
    "Waiting": "Wartet",
    # Poses, bake
    "Poses": "Posen",
    "Apply": "Setzen",
    "Blend": "Mischen",
    "Mirror": "Spiegeln",
    "Poses to Shape Keys": "Posen zu Shape Keys",
    "Press + to store where the handles are.": "Mit + wird gespeichert, wo die Griffe sind.",
    "Bake": "Backen",
    "Bake Pose": "Pose backen",
    "Bake Animation": "Animation backen",
    "Export Mesh Cache": "Mesh Cache ausgeben",
    # Show, settings
    "Strain": "Dehnung",
    "Full Color At": "Volle Farbe",
    "Overlays are off in this view": "Overlays sind in dieser Ansicht aus",
    "Shape Key": "Shape Key",
    "Smooth": "Weich",
    "Rigidity": "Starrheit",
    "Weights": "Gewichte",
    "Cotangent": "Kotangens",
    "Uniform": "Gleich",
    "Start From": "Beginn",
    "Previous Pose": "Vorige Pose",
    "Smooth Blend": "Weicher Übergang",
    "At Most": "Höchstens",
    "Accuracy": "Genauigkeit",
    "Join Seams": "Nahtlos",
    # What is reported, and why something cannot be done
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
    "Go to Object Mode first (Tab)": "Zuerst in den Objektmodus gehen (Tab)",
    "Go to Object Mode first, in the menu at the top left of the view": (
        "Zuerst in den Objektmodus gehen, im Menü oben links in der Ansicht"
    ),
    "Wait until the render has ended": "Warten, bis das Rendern beendet ist",
    "Add a handle first: nothing moves the mesh yet": "Zuerst einen Griff setzen: noch bewegt nichts das Mesh",
    "Add a pin first: nothing is pinned yet": "Zuerst einen Fixpunkt setzen: noch ist nichts festgehalten",
    "Add a stiff group first: nothing is stiffer than the rest yet": (
        "Zuerst eine steife Gruppe anlegen: noch ist nichts steifer als der Rest"
    ),
    "There is no pose yet: press Pose or Solve first": "Es gibt noch keine Pose: zuerst Posieren oder Lösen",
}
