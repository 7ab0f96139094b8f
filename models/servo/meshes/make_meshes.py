#!/usr/bin/env python3
"""Writes the meshes of the servo, machine.urdf and the tables of GEOMETRY.md.

Standard library only; running it again reproduces every file byte for byte. Dimensions below are in mm
and assumed (no drawing of the machine is published); only the inertia about the shaft is derived, from
the published transfer function. The thickness of the disc is the free dimension that meets it.
"""
import math
from pathlib import Path

MESHES = Path(__file__).resolve().parent
MODEL = MESHES.parent

TORQUE_CONSTANT_NM_PER_A = 0.5                          # assumed
INERTIA_KG_M2 = TORQUE_CONSTANT_NM_PER_A / 9975.0       # T(s) = 9975/(s + 1.6)
STEEL, ALUMINIUM, MOTOR = 7850.0, 2700.0, 4200.0        # motor: housing, laminations and copper taken as one
SIDES = 48

# Profiles (radius, height) from the axis at the bottom to the axis at the top; z = 0: front face of the motor.
HOUSING = [(0, -95), (29, -95), (29, -92), (27, -90), (27, -6), (20, -2), (20, 0), (0, 0)]
FLANGE_WIDTH, FLANGE_THICKNESS, FLANGE_FACE = 58.0, 7.0, -3.0
SHAFT = [(0, -80), (4.5, -80), (4.5, -72), (9, -72), (9, -28), (4.5, -28), (4.5, 26), (0, 26)]
COUPLING = [(0, 12), (12.5, 12), (12.5, 24), (11, 25), (11, 27), (12.5, 28), (12.5, 40), (0, 40)]
DISC_RADIUS, DISC_FOOT = 35.0, 40.0


class Solid:
    """Vertices in mm and triangles, outward counter-clockwise; equal vertices are one."""

    def __init__(self):
        self.vertices, self.triangles, self._index = [], [], {}

    def vertex(self, p):
        key = tuple(round(c, 9) + 0.0 for c in p)
        if key not in self._index:
            self._index[key] = len(self.vertices)
            self.vertices.append(key)
        return self._index[key]

    def face(self, a, b, c):
        corners = tuple(self.vertex(p) for p in (a, b, c))
        if len(set(corners)) == 3:
            self.triangles.append(corners)


def turned(profile):
    """A profile turned about z into a solid of so many sides."""
    solid = Solid()

    def at(point, k):
        angle = 2.0 * math.pi * (k % SIDES) / SIDES
        return (point[0] * math.cos(angle), point[0] * math.sin(angle), point[1])

    for low, high in zip(profile, profile[1:]):
        for k in range(SIDES):
            a, b, c, d = at(low, k), at(low, k + 1), at(high, k + 1), at(high, k)
            solid.face(a, b, c)
            solid.face(a, c, d)
    return solid


def box(width, depth, low, high):
    solid = Solid()
    x, y = width / 2, depth / 2
    ring = [(x, -y), (x, y), (-x, y), (-x, -y)]
    for k in range(4):
        p, q = ring[k], ring[(k + 1) % 4]
        solid.face((*p, low), (*q, low), (*q, high))
        solid.face((*p, low), (*q, high), (*p, high))
    solid.face((*ring[0], high), (*ring[1], high), (*ring[2], high))
    solid.face((*ring[0], high), (*ring[2], high), (*ring[3], high))
    solid.face((*ring[2], low), (*ring[1], low), (*ring[0], low))
    solid.face((*ring[3], low), (*ring[2], low), (*ring[0], low))
    return solid


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


def metres(solid):
    """The numbers written are the numbers the mass properties are taken from."""
    return [tuple(float(f"{c / 1000:.12g}") for c in v) for v in solid.vertices]


def write_obj(name, solid):
    points = metres(solid)
    lines = [f"# {name}, unit m, z along the shaft"] + [f"v {x:.12g} {y:.12g} {z:.12g}" for x, y, z in points]
    lines += ["f " + " ".join(str(i + 1) for i in t) for t in solid.triangles]
    (MESHES / f"{name}.obj").write_text("\n".join(lines) + "\n", newline="\n")
    return points


def exact(x, scale):
    """Full precision; what is rounding noise beside `scale` (by symmetry zero) is written as zero."""
    return "0" if abs(x) < 1e-9 * scale else repr(x)


def link(name, meshes, properties):
    mass, centre, tensor = properties
    size = max(abs(v) for v in tensor.values())
    i = {"xyz"[a] + "xyz"[b]: exact(v, size) for (a, b), v in tensor.items()}
    attributes = " ".join(f'i{k}="{i[k]}"' for k in ("xx", "xy", "xz", "yy", "yz", "zz"))
    visuals = "".join(f"""    <visual>
      <geometry><mesh filename="meshes/{mesh}.obj"/></geometry>
      <material name="{colour}"/>
    </visual>
""" for mesh, colour in meshes)
    return f"""  <link name="{name}">
    <inertial>
      <origin xyz="{' '.join(exact(c, 1.0) for c in centre)}" rpy="0 0 0"/>
      <mass value="{mass!r}"/>
      <inertia {attributes}/>
    </inertial>
{visuals}  </link>
"""


def fixed(child, parent):
    return f"""  <joint name="{child}_mount" type="fixed">
    <parent link="{parent}"/>
    <child link="{child}"/>
    <origin xyz="0 0 0" rpy="0 0 0"/>
  </joint>
"""


def main():
    solids = {"housing": turned(HOUSING),
              "flange": box(FLANGE_WIDTH, FLANGE_WIDTH, FLANGE_FACE - FLANGE_THICKNESS, FLANGE_FACE),
              "shaft": turned(SHAFT), "coupling": turned(COUPLING)}
    density = {"housing": MOTOR, "flange": ALUMINIUM, "shaft": STEEL, "coupling": ALUMINIUM, "disc": ALUMINIUM}

    def disc(thickness):
        return turned([(0, DISC_FOOT), (DISC_RADIUS, DISC_FOOT),
                       (DISC_RADIUS, DISC_FOOT + thickness), (0, DISC_FOOT + thickness)])

    def of(name):
        return mass_properties(metres(solids[name]), solids[name].triangles, density[name])

    others = of("shaft")[2][2, 2] + of("coupling")[2][2, 2]
    solids["disc"] = disc(1.0)
    thickness = round((INERTIA_KG_M2 - others) / of("disc")[2][2, 2], 9)
    solids["disc"] = disc(thickness)
    properties = {}
    for name, solid in solids.items():
        properties[name] = mass_properties(write_obj(name, solid), solid.triangles, density[name])
    total = sum(properties[name][2][2, 2] for name in ("shaft", "coupling", "disc"))
    assert abs(total / INERTIA_KG_M2 - 1.0) < 1e-9, total

    colours = {"housing_black": "0.16 0.17 0.18 1", "flange_grey": "0.62 0.64 0.66 1", "steel": "0.72 0.74 0.76 1",
               "anodised": "0.55 0.16 0.14 1", "aluminium": "0.80 0.81 0.83 1"}
    head = ('<?xml version="1.0"?>\n<!-- Written by meshes/make_meshes.py: change it there. '
            'Lengths in m; frames and marks in GEOMETRY.md. -->\n<robot name="servo">\n')
    materials = "".join(f'  <material name="{n}"><color rgba="{c}"/></material>\n' for n, c in colours.items())
    parts = [link("motor", [("housing", "housing_black")], properties["housing"]),
             link("flange", [("flange", "flange_grey")], properties["flange"]),
             link("shaft", [("shaft", "steel")], properties["shaft"]),
             link("coupling", [("coupling", "anodised")], properties["coupling"]),
             link("disc", [("disc", "aluminium")], properties["disc"]),
             fixed("flange", "motor"),
             """  <joint name="rotor" type="continuous">
    <parent link="motor"/>
    <child link="shaft"/>
    <origin xyz="0 0 0" rpy="0 0 0"/>
    <axis xyz="0 0 1"/>
  </joint>
""", fixed("coupling", "shaft"), fixed("disc", "shaft")]
    (MODEL / "machine.urdf").write_text(head + materials + "".join(parts) + "</robot>\n", newline="\n")

    rows = "\n".join(f"| {name} (`{'motor' if name == 'housing' else name}`) | {density[name]:.0f} | {p[0]:.4f} | {p[2][2, 2]:.5e} | A |"
                     for name, p in properties.items())
    (MODEL / "GEOMETRY.md").write_text(f"""## Geometry and masses

No drawing of the machine is published. Every dimension here is **assumed (A)**: a motor, a coupling and a disc whose
inertia about the shaft is what the published transfer function says ({INERTIA_KG_M2:.5e} kg·m², **derived (D)**). `meshes/make_meshes.py`
writes the meshes, `machine.urdf` and this page; mass, centre and inertia in the URDF are the integrals over the meshes as written,
solids of {SIDES} sides. All frames lie on the shaft's axis, z outward, with their origin in the front face of the motor.

| part | density, kg/m³ | mass, kg | inertia about the shaft, kg·m² | mark |
|---|---|---|---|---|
{rows}

Shaft (with rotor), coupling and disc turn: together {total:.8e} kg·m² (wanted {INERTIA_KG_M2:.8e}). The disc, radius {DISC_RADIUS:.0f} mm, is
{thickness:.4f} mm thick: the free dimension. Densities: steel 7850, aluminium 2700, motor housing 4200 (housing, laminations and copper
taken as one) — A. Their mass acts on nothing: the axis is balanced.
""", newline="\n")
    print(thickness, total)


if __name__ == "__main__":
    main()
