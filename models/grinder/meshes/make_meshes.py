#!/usr/bin/env python3
"""Writes the meshes of the worktable axis, machine.urdf and the tables of GEOMETRY.md.

Standard library only; running it again reproduces every file byte for byte. Dimensions below are in mm
and assumed (no drawing of the machine is published); only the moving mass, 51.28 kg, is derived from
the published transfer function. The thickness of the table is the free dimension that meets it.
"""
import math
import struct
from pathlib import Path

MESHES = Path(__file__).resolve().parent
MODEL = MESHES.parent

MOVING_MASS_KG = 51.28
STEEL, CAST_IRON, MAGNET_PLATE = 7850.0, 7200.0, 7700.0

TABLE_LENGTH, TABLE_WIDTH, TABLE_CHAMFER = 460.0, 280.0, 2.0
SLOT_PITCH, SLOT_MOUTH, SLOT_THROAT, SLOT_WIDTH, SLOT_HEIGHT = 63.0, 12.0, 10.0, 20.0, 8.0
PAD_INNER, PAD_DEPTH = 62.0, 6.0                # recess between the carriage pads takes the magnet plates
LIP_LENGTH, LIP_HEIGHT = 15.0, 20.0
RAIL_Y, RAIL_LENGTH, RAIL_HEIGHT = 90.0, 1200.0, 22.0
ASSEMBLY_HEIGHT = 40.0                          # rail foot to carriage top
SLIDER_X, SLIDER_LENGTH, RACEWAY_Z = 150.0, 84.0, -26.0
MAGNET_Y, MAGNET_WIDTH, MAGNET_LENGTH = 31.0, 58.0, 360.0
YOKE, MAGNET, MAGNET_PITCH, MAGNET_GAP = 6.0, 5.0, 30.0, 4.0
BED_LENGTH = 1300.0


# ---- polygons (y, z), counter-clockwise seen from +x -------------------------------------------

def area2(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])


def signed_area(p):
    return 0.5 * sum(p[i - 1][0] * p[i][1] - p[i][0] * p[i - 1][1] for i in range(len(p)))


def triangulate(polygon):
    """Ear clipping of a simple polygon; returns index triples, counter-clockwise."""
    left, triangles = list(range(len(polygon))), []
    while len(left) > 3:
        best = None
        for k in range(len(left)):
            i, j, l = left[k - 1], left[k], left[(k + 1) % len(left)]
            a, b, c = polygon[i], polygon[j], polygon[l]
            if area2(a, b, c) <= 1e-9:
                continue
            inside = (m for m in left if m not in (i, j, l))
            if any(min(area2(a, b, polygon[m]), area2(b, c, polygon[m]), area2(c, a, polygon[m])) >= -1e-9
                   for m in inside):
                continue
            quality = area2(a, b, c) / max(math.dist(a, b), math.dist(b, c), math.dist(c, a)) ** 2
            if best is None or quality > best[0] + 1e-12:
                best = (quality, k, (i, j, l))
        if best is None:
            raise ValueError("polygon is not simple")
        triangles.append(best[2])
        del left[best[1]]
    triangles.append(tuple(left))
    return triangles


class Solid:
    """Vertices in mm and triangles, outward counter-clockwise; equal vertices are one."""

    def __init__(self):
        self.vertices, self.triangles, self._index = [], [], {}

    def vertex(self, p):
        key = tuple(round(c, 6) + 0.0 for c in p)
        if key not in self._index:
            self._index[key] = len(self.vertices)
            self.vertices.append(key)
        return self._index[key]

    def face(self, a, b, c):
        self.triangles.append(tuple(self.vertex(p) for p in (a, b, c)))

    def cap(self, polygon, at, outward):
        """Closes a polygon of the plane that `at` maps into space; `outward` = +1 or -1."""
        for t in triangulate(polygon):
            corners = [at(polygon[i]) for i in t]
            self.face(*(corners if outward > 0 else corners[::-1]))

    def walls(self, polygon, at_low, at_high):
        for k, p in enumerate(polygon):
            q = polygon[(k + 1) % len(polygon)]
            a, b, c, d = at_low(p), at_low(q), at_high(q), at_high(p)
            self.face(a, b, c)
            self.face(a, c, d)

    def scaled(self, factor):
        return [tuple(c * factor for c in v) for v in self.vertices]


def along_x(x):
    return lambda p: (x, p[0], p[1])


def prism_x(polygon, length):
    """Extrudes a (y, z) polygon over -length/2 … +length/2 along x."""
    assert signed_area(polygon) > 0
    solid = Solid()
    low, high = along_x(-length / 2), along_x(length / 2)
    solid.walls(polygon, low, high)
    solid.cap(polygon, low, -1)
    solid.cap(polygon, high, +1)
    return solid


def mirrored(right):
    """A polygon symmetric in y from its right half, listed from the bottom up."""
    return right + [(-y, z) for y, z in reversed(right)]


# ---- parts --------------------------------------------------------------------------------------

def table(thickness):
    """T-slotted slab with chamfered edges, a recess below and a lip at either end. z = 0: carriage pads."""
    half, top = TABLE_WIDTH / 2, thickness
    side = [(half, 0.0), (half, LIP_HEIGHT), (half, top - TABLE_CHAMFER), (half - TABLE_CHAMFER, top)]
    upper = []
    for centre in (SLOT_PITCH, 0.0, -SLOT_PITCH):
        m, w = SLOT_MOUTH / 2, SLOT_WIDTH / 2
        throat, floor = top - SLOT_THROAT, top - SLOT_THROAT - SLOT_HEIGHT
        upper += [(centre + y, z) for y, z in (
            (m + 1.0, top), (m, top - 1.0), (m, throat), (w, throat), (w, floor),
            (-w, floor), (-w, throat), (-m, throat), (-m, top - 1.0), (-m - 1.0, top))]
    recess = [(-PAD_INNER, 0.0), (-PAD_INNER, PAD_DEPTH), (PAD_INNER, PAD_DEPTH), (PAD_INNER, 0.0)]
    left = [(-y, z) for y, z in reversed(side)]
    body = recess + side + upper + left
    lip = recess + [(half, 0.0), (half, LIP_HEIGHT), (-half, LIP_HEIGHT), (-half, 0.0)]
    above = [(-half, LIP_HEIGHT), (half, LIP_HEIGHT)] + side[2:] + upper + left[:-2]
    solid = Solid()
    end, tip = TABLE_LENGTH / 2, TABLE_LENGTH / 2 + LIP_LENGTH
    solid.walls(body, along_x(-end), along_x(end))
    for sign in (1, -1):
        solid.cap(above, along_x(sign * end), sign)
        solid.cap(lip, along_x(sign * tip), sign)
        solid.walls(lip, along_x(min(sign * end, sign * tip)), along_x(max(sign * end, sign * tip)))
    return solid


def rail():
    """Profile rail: foot, waist with the raceways, head. z = 0: foot."""
    right = [(11.5, 0.0), (11.5, 8.0), (8.5, 11.0), (8.5, 15.0), (11.5, 18.0), (11.5, 21.0), (10.5, 22.0)]
    return prism_x(mirrored(right), RAIL_LENGTH)


def slider():
    """Carriage: inverted U around the rail, reaching into its waist. z = 0: raceways."""
    outer = [(12.5, -8.0), (23.0, -8.0), (24.0, -7.0), (24.0, 25.0), (23.0, 26.0)]
    inner = [(12.5, 8.5), (12.5, 3.5), (9.5, 0.5), (9.5, -2.5), (12.5, -5.5)]
    left = [(-y, z) for y, z in reversed(outer)]
    return prism_x(outer + left + [(-y, z) for y, z in reversed(inner)] + inner, SLIDER_LENGTH)


def magnet_plate():
    """Steel yoke with a row of magnets below; one profile in (x, z), extruded across y. z = 0: mounting face."""
    end, yoke, face = MAGNET_LENGTH / 2, -YOKE, -YOKE - MAGNET
    profile = [(end, 0.0), (-end, 0.0), (-end, yoke)]
    count = round(MAGNET_LENGTH / MAGNET_PITCH)
    for k in range(count):
        centre = -end + (k + 0.5) * MAGNET_PITCH
        half = (MAGNET_PITCH - MAGNET_GAP) / 2
        profile += [(centre - half, yoke), (centre - half, face), (centre + half, face), (centre + half, yoke)]
    profile.append((end, yoke))
    assert signed_area(profile) > 0
    solid = Solid()

    def along_y(y):
        return lambda p: (p[0], y, p[1])

    # (x, z) is counter-clockwise seen from -y: the side at -y plays the part of the high end.
    low, high = along_y(MAGNET_WIDTH / 2), along_y(-MAGNET_WIDTH / 2)
    solid.walls(profile, low, high)
    solid.cap(profile, low, -1)
    solid.cap(profile, high, +1)
    return solid


def bed():
    """Bridge-shaped bed, open below, with two ways for the rails and two coil tracks. z = 0: way surface."""
    right = [(120.0, -420.0), (260.0, -420.0), (260.0, -380.0), (210.0, -340.0), (170.0, -60.0),
             (170.0, -20.0), (115.0, -20.0), (110.0, 0.0), (70.0, 0.0), (66.0, -12.0),
             (58.0, -12.0), (58.0, 33.5), (4.0, 33.5), (4.0, -12.0)]
    inner = [(-120.0, -420.0), (-100.0, -140.0), (-60.0, -100.0), (60.0, -100.0), (100.0, -140.0)]
    left = [(-y, z) for y, z in reversed(right)][:-1]
    return prism_x(right + left + inner, BED_LENGTH)


# ---- mass properties of a polyhedron -------------------------------------------------------------

def mass_properties(vertices, triangles, density):
    """Mass, centre and tensor about the centre; vertices in m. Exact integrals over tetrahedra."""
    volume, first, second = [], [[], [], []], {(i, j): [] for i in range(3) for j in range(i, 3)}
    for t in triangles:
        a, b, c = (vertices[i] for i in t)
        d = (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
             + a[2] * (b[0] * c[1] - b[1] * c[0]))
        s = [a[i] + b[i] + c[i] for i in range(3)]
        volume.append(d / 6)
        for i in range(3):
            first[i].append(d / 24 * s[i])
            for j in range(i, 3):
                second[i, j].append(d / 120 * (s[i] * s[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]))
    v = math.fsum(volume)
    centre = [math.fsum(f) / v for f in first]
    c2 = {k: density * (math.fsum(x) - v * centre[k[0]] * centre[k[1]]) for k, x in second.items()}
    trace = c2[0, 0] + c2[1, 1] + c2[2, 2]
    tensor = {k: (trace - x if k[0] == k[1] else -x) for k, x in c2.items()}
    return density * v, centre, tensor


# ---- files ---------------------------------------------------------------------------------------

def write_obj(name, solid):
    """OBJ in m: the numbers written are the numbers the mass properties are taken from."""
    metres = [tuple(float(f"{c / 1000:.9g}") for c in v) for v in solid.vertices]
    lines = [f"# {name}, unit m, z up"] + [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in metres]
    lines += ["f " + " ".join(str(i + 1) for i in t) for t in solid.triangles]
    (MESHES / f"{name}.obj").write_text("\n".join(lines) + "\n", newline="\n")
    return metres


def write_stl(name, solid):
    """Binary STL in mm; the coordinates are multiples of 0.5 mm, exact in single precision."""
    data = [f"{name}, unit mm, z up".encode().ljust(80), struct.pack("<I", len(solid.triangles))]
    for t in solid.triangles:
        a, b, c = (solid.vertices[i] for i in t)
        u, w = [b[i] - a[i] for i in range(3)], [c[i] - a[i] for i in range(3)]
        n = (u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0])
        length = math.hypot(*n)
        data.append(struct.pack("<12fH", *(x / length for x in n), *a, *b, *c, 0))
    (MESHES / f"{name}.stl").write_bytes(b"".join(data))
    return solid.scaled(0.001)


def number(x):
    return repr(round(x, 12) + 0.0)


def exact(x, scale):
    """Full precision; what is rounding noise beside `scale` (by symmetry zero) is written as zero."""
    return "0" if abs(x) < 1e-14 * scale else repr(x)


def link(name, mesh, mm, properties, colour):
    mass, centre, tensor = properties
    scale = ' scale="0.001 0.001 0.001"' if mm else ""
    size = max(abs(v) for v in tensor.values())
    i = {"xyz"[a] + "xyz"[b]: exact(v, size) for (a, b), v in tensor.items()}
    attributes = " ".join(f'i{k}="{i[k]}"' for k in ("xx", "xy", "xz", "yy", "yz", "zz"))
    return f"""  <link name="{name}">
    <inertial>
      <origin xyz="{' '.join(exact(c, 1.0) for c in centre)}" rpy="0 0 0"/>
      <mass value="{mass!r}"/>
      <inertia {attributes}/>
    </inertial>
    <visual>
      <geometry><mesh filename="meshes/{mesh}"{scale}/></geometry>
      <material name="{colour}"/>
    </visual>
  </link>
"""


def fixed(child, parent, mm):
    xyz = " ".join(number(c / 1000) for c in mm)
    return f"""  <joint name="{child}_mount" type="fixed">
    <parent link="{parent}"/>
    <child link="{child}"/>
    <origin xyz="{xyz}" rpy="0 0 0"/>
  </joint>
"""


SLIDERS = {"slider_a": (1, 1), "slider_b": (-1, 1), "slider_c": (1, -1), "slider_d": (-1, -1)}
MAGNETS = {"magnet_plate_left": 1, "magnet_plate_right": -1}


def urdf(properties):
    parts = [
        link("base", "bed.obj", False, properties["bed"], "bed_green"),
        link("rail_left", "rail.obj", False, properties["rail"], "rail_steel"),
        link("rail_right", "rail.obj", False, properties["rail"], "rail_steel"),
        link("worktable", "worktable.obj", False, properties["worktable"], "cast_iron"),
        *(link(name, "slider.stl", True, properties["slider"], "carriage_steel") for name in SLIDERS),
        *(link(name, "magnet_plate.obj", False, properties["magnet_plate"], "magnet") for name in MAGNETS),
        fixed("rail_left", "base", (0, RAIL_Y, 0)),
        fixed("rail_right", "base", (0, -RAIL_Y, 0)),
        f"""  <joint name="table_slide" type="prismatic">
    <parent link="base"/>
    <child link="worktable"/>
    <origin xyz="0 0 {number(ASSEMBLY_HEIGHT / 1000)}" rpy="0 0 0"/>
    <axis xyz="1 0 0"/>
    <limit lower="-0.35" upper="0.35" effort="2000" velocity="1.0"/>
  </joint>
""",
        *(fixed(n, "worktable", (fx * SLIDER_X, fy * RAIL_Y, RACEWAY_Z)) for n, (fx, fy) in SLIDERS.items()),
        *(fixed(n, "worktable", (0, fy * MAGNET_Y, PAD_DEPTH)) for n, fy in MAGNETS.items()),
    ]
    colours = {"bed_green": "0.32 0.40 0.38 1", "rail_steel": "0.72 0.74 0.76 1", "cast_iron": "0.45 0.47 0.50 1",
               "carriage_steel": "0.58 0.60 0.63 1", "magnet": "0.78 0.66 0.42 1"}
    materials = "".join(f'  <material name="{n}"><color rgba="{c}"/></material>\n' for n, c in colours.items())
    head = ('<?xml version="1.0"?>\n<!-- Written by meshes/make_meshes.py: change it there. '
            'Lengths in m; frames and marks in GEOMETRY.md. -->\n<robot name="grinder">\n')
    (MODEL / "machine.urdf").write_text(head + materials + "".join(parts) + "</robot>\n", newline="\n")


def geometry_notes(thickness, properties, moving, moving_centre_z):
    rows = [("bed (`base`)", "bed", CAST_IRON, 1), ("rail (`rail_left`, `rail_right`)", "rail", STEEL, 2),
            ("worktable (`worktable`)", "worktable", CAST_IRON, 1),
            ("bearing slider (`slider_a` … `slider_d`)", "slider", STEEL, 4),
            ("magnet plate (`magnet_plate_left`, `magnet_plate_right`)", "magnet_plate", MAGNET_PLATE, 2)]
    masses = "\n".join(
        f"| {label} | {count} | {density:.0f} | {properties[key][0]:.4f} | "
        + " ".join(f"{1000 * c + 0.0:.3f}" for c in (round(c, 9) for c in properties[key][1])) + " | A |"
        for label, key, density, count in rows)
    working = PAD_DEPTH - YOKE - MAGNET
    sliders = "\n".join(f"| `{n}` | {fx * SLIDER_X:.0f} {fy * RAIL_Y:.0f} {RACEWAY_Z:.0f} | "
                        f"{'front' if fx > 0 else 'back'} (x {'>' if fx > 0 else '<'} 0), "
                        f"{'left' if fy > 0 else 'right'} rail (y {'>' if fy > 0 else '<'} 0) |"
                        for n, (fx, fy) in SLIDERS.items())
    text = f"""## Geometry and masses

No drawing of the machine is published. Every dimension here is **assumed (A)**: a table of this kind that weighs what
the published transfer function says (51.28 kg, **derived (D)**). `meshes/make_meshes.py` writes the meshes,
`machine.urdf` and this page; mass, centre and inertia in the URDF are the integrals over the meshes as written.
Lengths on this page in mm, x along travel, y to the left, z up.

### Frames
| frame | place |
|---|---|
| `base` | middle of the bed, on the way surface that carries the rails |
| `worktable` | middle of the table, on the carriage pads; at joint position zero it lies at (0, 0, {ASSEMBLY_HEIGHT:.0f}) of `base` |
| `slider_*` | middle of a carriage, at the height of the raceways: the point where its load acts |
| `magnet_plate_*` | middle of a plate's mounting face |

### Masses (per part)
| part | count | density, kg/m³ | mass, kg | centre in its frame, mm | mark |
|---|---|---|---|---|---|
{masses}

Moving mass {moving:.4f} kg (wanted {MOVING_MASS_KG}), centre at z = {1000 * moving_centre_z:.3f} in `worktable`.
Densities: grey cast iron {CAST_IRON:.0f}, steel {STEEL:.0f}, magnet plate {MAGNET_PLATE:.0f} (steel yoke and NdFeB taken as one) — A.

### Sliders, in `worktable`
| slider | centre, mm | |
|---|---|---|
{sliders}

Wheelbase {2 * SLIDER_X:.0f} along x, gauge {2 * RAIL_Y:.0f} along y.

### Motors
Two linear motors, magnets on the table, coils on the bed. The thrust acts on the working faces of the magnet plates, along +x
through these points of `worktable` (half of the total each, A):

| motor | point, mm |
|---|---|
| left | 0 {MAGNET_Y:.0f} {working:.0f} |
| right | 0 {-MAGNET_Y:.0f} {working:.0f} |

So the line of action lies {1000 * moving_centre_z - working:.3f} below the centre of mass: accelerating along +x unloads the front
sliders (A, C) and loads the back ones (B, D).

### Dimensions (all A)
| what | mm |
|---|---|
| table length × width × thickness (thickness fitted to the mass) | {TABLE_LENGTH:.0f} × {TABLE_WIDTH:.0f} × {thickness:.2f} |
| T-slots: count, pitch, mouth, throat depth, width, height | 3, {SLOT_PITCH:.0f}, {SLOT_MOUTH:.0f}, {SLOT_THROAT:.0f}, {SLOT_WIDTH:.0f}, {SLOT_HEIGHT:.0f} |
| table edge chamfer; slot edge chamfer | {TABLE_CHAMFER:.0f}; 1 |
| recess below: width, depth | {2 * PAD_INNER:.0f}, {PAD_DEPTH:.0f} |
| end lips: length, height | {LIP_LENGTH:.0f}, {LIP_HEIGHT:.0f} |
| rail: length, width, height, waist; distance between rails | {RAIL_LENGTH:.0f}, 23, {RAIL_HEIGHT:.0f}, 17; {2 * RAIL_Y:.0f} |
| rail foot to carriage top | {ASSEMBLY_HEIGHT:.0f} |
| carriage: length × width × height | {SLIDER_LENGTH:.0f} × 48 × 34 |
| magnet plate: length × width, yoke, magnets, pitch, gap | {MAGNET_LENGTH:.0f} × {MAGNET_WIDTH:.0f}, {YOKE:.0f}, {MAGNET:.0f}, {MAGNET_PITCH:.0f}, {MAGNET_GAP:.0f} |
| air gap between magnets and coil track | {ASSEMBLY_HEIGHT + working - 33.5:.1f} |
| bed length; height below the ways | {BED_LENGTH:.0f}; 420 |
| travel; largest effort; largest speed | ±350; 2000 N; 1 m/s |
"""
    (MODEL / "GEOMETRY.md").write_text(text, newline="\n")


def main():
    parts = {"bed": (bed(), CAST_IRON, write_obj), "rail": (rail(), STEEL, write_obj),
             "slider": (slider(), STEEL, write_stl), "magnet_plate": (magnet_plate(), MAGNET_PLATE, write_obj)}
    properties = {name: mass_properties(write(name, s), s.triangles, density)
                  for name, (s, density, write) in parts.items()}
    others = 4 * properties["slider"][0] + 2 * properties["magnet_plate"][0]

    def table_mass(thickness):
        t = table(thickness)
        return mass_properties(t.scaled(0.001), t.triangles, CAST_IRON)[0]

    low, high = 30.0, 90.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if table_mass(middle) + others < MOVING_MASS_KG else (low, middle)
    thickness = round(low, 2)
    solid = table(thickness)
    properties["worktable"] = mass_properties(write_obj("worktable", solid), solid.triangles, CAST_IRON)
    heights = [(properties["worktable"], 0.0)] + 4 * [(properties["slider"], RACEWAY_Z / 1000)]
    heights += 2 * [(properties["magnet_plate"], PAD_DEPTH / 1000)]
    moving = math.fsum(p[0] for p, _ in heights)
    centre_z = math.fsum(p[0] * (p[1][2] + z) for p, z in heights) / moving
    urdf(properties)
    geometry_notes(thickness, properties, moving, centre_z)


if __name__ == "__main__":
    main()
