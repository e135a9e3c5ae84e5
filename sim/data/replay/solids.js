/* The shapes of which the view in three dimensions is built, as triangles. */

const SIDES = 20;            // of what is round
const SIDES_OF_VOLUMES = 72; // of what is large and round

/** A list of triangles: of each vertex position, normal, and how much of its opacity it has. */
class Mesh {
  constructor() {
    this.vertices = [];
    this.triangles = [];
  }

  vertex(position, normal, fade = 1) {
    this.vertices.push(...position, ...normal, fade);
    return this.vertices.length / 7 - 1;
  }

  /** A flat face of points in order, counterclockwise seen from outside; it must be convex. */
  face(points, normal) {
    const [first, ...others] = points.map(point => this.vertex(point, normal));
    for (let i = 1; i < others.length; i++) this.triangles.push(first, others[i - 1], others[i]);
    return this;
  }
}

/** The unit cube: x and y from -1/2 to 1/2, z from 0 to 1. */
function boxMesh() {
  const mesh = new Mesh();
  const [a, b] = [-0.5, 0.5];
  return mesh.face([[a, a, 1], [b, a, 1], [b, b, 1], [a, b, 1]], [0, 0, 1])
    .face([[a, b, 0], [b, b, 0], [b, a, 0], [a, a, 0]], [0, 0, -1])
    .face([[b, a, 0], [b, b, 0], [b, b, 1], [b, a, 1]], [1, 0, 0])
    .face([[a, b, 0], [a, a, 0], [a, a, 1], [a, b, 1]], [-1, 0, 0])
    .face([[b, b, 0], [a, b, 0], [a, b, 1], [b, b, 1]], [0, 1, 0])
    .face([[a, a, 0], [b, a, 0], [b, a, 1], [a, a, 1]], [0, -1, 0]);
}

/** The unit square on the floor. */
function squareMesh() {
  const [a, b] = [-0.5, 0.5];
  return new Mesh().face([[a, a, 0], [b, a, 0], [b, b, 0], [a, b, 0]], [0, 0, 1]);
}

/**
 * What turns about z: a profile of points [radius, z, fade], from below outwards to above. Its corners
 * are sharp, unless `isSmooth`.
 */
function turnedMesh(points, { isSmooth = false, sides = SIDES } = {}) {
  const mesh = new Mesh();
  const profile = points.filter(([r, z], i) => i === 0 || Math.hypot(r - points[i - 1][0], z - points[i - 1][1]) > 1e-9);
  const slopes = profile.slice(1).map(([r, z], i) => [z - profile[i][1], profile[i][0] - r]);
  const normalAt = (i, segment) => {
    const near = isSmooth ? [slopes[i - 1], slopes[i]].filter(Boolean) : [slopes[segment]];
    const sum = near.map(slope => slope.map(value => value / Math.hypot(...slope)))
      .reduce(([a, b], [c, d]) => [a + c, b + d]);
    return sum.map(value => value / Math.hypot(...sum));
  };
  slopes.forEach((_, segment) => {
    const rings = [segment, segment + 1].map(i => {
      const [radius, z, fade] = profile[i];
      const [outwards, upwards] = normalAt(i, segment);
      return Array.from({ length: sides + 1 }, (_, k) => {
        const [c, s] = [Math.cos((2 * Math.PI * k) / sides), Math.sin((2 * Math.PI * k) / sides)];
        return mesh.vertex([radius * c, radius * s, z], [outwards * c, outwards * s, upwards], fade);
      });
    });
    for (let k = 0; k < sides; k++) {
      const [[a, b], [d, c]] = rings.map(ring => [ring[k], ring[k + 1]]);
      mesh.triangles.push(a, b, c, a, c, d);
    }
  });
  return mesh;
}

/** Points of a half circle from below to above, stretched to the ends of a rod from `low` to `high`. */
function roundedProfile(low, high, cap, narrowest) {
  const quarter = Array.from({ length: 6 }, (_, i) => (Math.PI / 2) * (i / 5));
  return [
    ...quarter.map(angle => [0.5 * narrowest * Math.sin(angle), low + cap * (1 - Math.cos(angle))]),
    ...quarter.map(angle => [0.5 * Math.cos(angle), high - cap * (1 - Math.sin(angle))]),
  ];
}

const SMOOTH = { isSmooth: true };
const LARGE = { sides: SIDES_OF_VOLUMES };

/** The shapes by name; all fit into the unit cube but `ball`, which is round about its origin. */
const SOLIDS = {
  box: boxMesh,
  square: squareMesh,
  cylinder: () => turnedMesh([[0, 0], [0.5, 0], [0.5, 1], [0, 1]]),
  ball: () => turnedMesh(roundedProfile(-0.5, 0.5, 0.5, 1), SMOOTH),
  dome: () => turnedMesh(roundedProfile(0, 1, 1, 1).slice(6), SMOOTH),
  limb: () => turnedMesh(roundedProfile(-1, 0, 0.14, 0.74), SMOOTH),        // hangs down from its joint
  trunk: () => turnedMesh(roundedProfile(0, 1, 0.22, 0.8), SMOOTH),
  tube: () => turnedMesh([[0.5, 0, 1], [0.5, 1, 0]], LARGE),               // fades upwards
  disc: () => turnedMesh([[0.5, 0], [0, 0]], LARGE),
};

/** A ring on the floor, a metre across, of a line that is `width` metres wide. */
function ringMesh(width) {
  return turnedMesh([[0.5 + width / 2, 0], [0.5 - width / 2, 0]], LARGE);
}

/** An upright solid of any footprint (a ring of points), from one height to another. */
function prismMesh(footprint, bottom, top) {
  const ring = signedArea(footprint) > 0 ? footprint : [...footprint].reverse();
  const mesh = new Mesh();
  for (const [a, b, c] of trianglesIn(ring)) {
    mesh.face([a, b, c].map(point => [...point, top]), [0, 0, 1]);
    mesh.face([c, b, a].map(point => [...point, bottom]), [0, 0, -1]);
  }
  ring.forEach(([ax, ay], i) => {
    const [bx, by] = ring[(i + 1) % ring.length];
    const normal = unit([by - ay, ax - bx, 0]);
    if (normal.every(Number.isFinite)) {
      mesh.face([[ax, ay, bottom], [bx, by, bottom], [bx, by, top], [ax, ay, top]], normal);
    }
  });
  return mesh;
}

const signedArea = ring => ring.reduce((sum, [x, y], i) => {
  const [nx, ny] = ring[(i + 1) % ring.length];
  return sum + (x * ny - nx * y) / 2;
}, 0);

/** Cuts ears off a ring (counterclockwise) until it is gone; what crosses itself is cut as far as it goes. */
function trianglesIn(ring) {
  const left = [...ring];
  const found = [];
  const turns = ([ax, ay], [bx, by], [cx, cy]) => (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
  const isEar = (a, b, c) => turns(a, b, c) > 0 && !left.some(point => point !== a && point !== b && point !== c
    && turns(a, b, point) >= 0 && turns(b, c, point) >= 0 && turns(c, a, point) >= 0);
  while (left.length > 3) {
    const corner = i => left[(i + left.length) % left.length];
    const ear = left.findIndex((point, i) => isEar(corner(i - 1), point, corner(i + 1)));
    if (ear < 0) break;
    found.push([corner(ear - 1), corner(ear), corner(ear + 1)]);
    left.splice(ear, 1);
  }
  for (let i = 2; i < left.length; i++) found.push([left[0], left[i - 1], left[i]]);
  return found;
}
