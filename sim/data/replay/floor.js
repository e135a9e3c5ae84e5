/* The floor: ground, lanes, obstacles, places and their names. */

const SMALL_SCALE = 13;      // pixels a metre below which names are small
const PARKED = 0.4;       // metres from a location of an AGV that stay free of names of obstacles
const TALLEST = 2.5;      // metres: obstacles of this height are drawn darkest
const NEIGHBOUR = 0.3;    // metres between neighbours, at most
const PERSON_RADIUS = 0.3;
const LAYER_MARGIN = 160; // CSS pixels drawn beyond each edge, so that panning mostly shifts the picture

/** The floor as a picture, drawn again only when the camera leaves it. */
class FloorLayer {
  constructor(plan) {
    this.plan = plan;
    this.obstacles = plan.obstacles.map(obstacle => ({ ...obstacle, box: boxOf(obstacle.footprint) }))
      .sort((a, b) => a.top - b.top);
    this.groups = groupsOf(this.obstacles);
    this.canvas = document.createElement("canvas");
    this.seen = null;
    this.names = [];           // boxes of the names of places in the picture, CSS pixels
  }

  /** Forget the picture: the colours have changed. */
  invalidate() {
    this.seen = null;
  }

  /** Draws the floor; returns the boxes of the names of stations and safe zone on the screen. */
  draw(context, camera, palette) {
    if (!this.#covers(camera)) this.#paint(camera, palette);
    const dx = (this.seen.x - camera.x) * camera.scale;
    const dy = -(this.seen.y - camera.y) * camera.scale;
    const whole = value => Math.round(value * camera.ratio) / camera.ratio;
    context.drawImage(this.canvas, whole(dx) - LAYER_MARGIN, whole(dy) - LAYER_MARGIN,
      this.canvas.width / camera.ratio, this.canvas.height / camera.ratio);
    return this.names.map(({ left, right, top, bottom }) => (
      { left: left + dx, right: right + dx, top: top + dy, bottom: bottom + dy }));
  }

  /** The obstacle at a place of the floor, the tallest first. */
  obstacleAt(x, y) {
    return this.obstacles.findLast(obstacle => isInside(obstacle.footprint, x, y));
  }

  #covers(camera) {
    const seen = this.seen;
    return seen && seen.scale === camera.scale && seen.ratio === camera.ratio
      && seen.width === camera.width && seen.height === camera.height
      && Math.abs(seen.x - camera.x) * camera.scale <= LAYER_MARGIN
      && Math.abs(seen.y - camera.y) * camera.scale <= LAYER_MARGIN;
  }

  #paint(camera, palette) {
    const { x, y, scale, width, height, ratio } = camera;
    this.seen = { x, y, scale, width, height, ratio };
    this.canvas.width = Math.round((width + 2 * LAYER_MARGIN) * ratio);
    this.canvas.height = Math.round((height + 2 * LAYER_MARGIN) * ratio);
    const context = this.canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, LAYER_MARGIN * ratio, LAYER_MARGIN * ratio);

    const pen = { context, camera, palette };
    this.paintGround(pen);
    this.#paintGantryRails(pen);
    for (const obstacle of this.obstacles) this.#paintObstacle(pen, obstacle);
    this.#paintNames(pen);
  }

  /** Paints what lies on the floor: the ground, lanes, stations and the safe zone. */
  paintGround(pen) {
    this.#paintFloor(pen);
    this.#paintLanes(pen);
    this.#paintPlaces(pen);
  }

  #paintFloor({ context, camera, palette }) {
    const { left, right, bottom, top } = boxOf(this.plan.boundary);
    const rings = [this.plan.boundary, ...this.plan.holes ?? []];
    outline(context, camera, ...rings);
    context.fillStyle = palette.floor;
    context.fill("evenodd");
    context.save();
    context.clip("evenodd");
    const spacing = [1, 2, 5, 10, 20, 50].find(metres => metres * camera.scale >= 40) ?? 100;
    context.strokeStyle = palette.grid;
    context.lineWidth = 1;
    context.beginPath();
    for (let x = Math.ceil(left / spacing) * spacing; x <= right; x += spacing) {
      context.moveTo(...camera.toScreen(x, bottom));
      context.lineTo(...camera.toScreen(x, top));
    }
    for (let y = Math.ceil(bottom / spacing) * spacing; y <= top; y += spacing) {
      context.moveTo(...camera.toScreen(left, y));
      context.lineTo(...camera.toScreen(right, y));
    }
    context.stroke();
    context.restore();
    outline(context, camera, ...rings);
    context.strokeStyle = palette.edge;
    context.lineWidth = 1.2;
    context.stroke();
  }

  #paintLanes({ context, camera, palette }) {
    context.strokeStyle = palette.edge;
    context.lineWidth = 1;
    context.setLineDash([1, 4]);
    for (const course of this.plan.courses) strokePath(context, camera, course);
    context.setLineDash([]);
    for (const { locations } of this.plan.lanes) {
      for (const place of Object.values(locations)) {
        const [px, py] = camera.toScreen(...place);
        context.strokeRect(px - 2.5, py - 2.5, 5, 5);
      }
    }
  }

  #paintGantryRails({ context, camera, palette }) {
    const { gantry } = this.plan;
    if (!gantry) return;
    context.strokeStyle = palette.robot;
    context.lineWidth = 2;
    alpha(context, 0.45, () => {
      for (const y of gantry.y) {
        strokePath(context, camera, [[gantry.x[0], y], [gantry.x[1], y]]);
        for (const x of gantry.x) {
          const [px, py] = camera.toScreen(x, y);
          context.strokeRect(px - 1.5, py - 4, 3, 8);
        }
      }
    });
  }

  #paintObstacle({ context, camera, palette }, { footprint, bottom, top }) {
    outline(context, camera, footprint);
    context.lineWidth = 1;
    context.strokeStyle = palette.edge;
    if (bottom > 0) {                      // overhead: people walk under it
      context.setLineDash([3, 3]);
      context.stroke();
      context.setLineDash([]);
      return;
    }
    context.fillStyle = palette.low;
    context.fill();
    alpha(context, Math.min(1, top / TALLEST) ** 1.5, () => {
      context.fillStyle = palette.high;
      context.fill();
    });
    context.stroke();
  }

  #paintPlaces({ context, camera, palette }) {
    context.lineWidth = 1.5;
    for (const { at } of this.plan.stations) {
      const [px, py] = camera.toScreen(...at);
      context.strokeStyle = palette.text;
      context.beginPath();
      context.arc(px, py, 5, 0, 2 * Math.PI);
      context.moveTo(px - 8, py);
      context.lineTo(px + 8, py);
      context.moveTo(px, py - 8);
      context.lineTo(px, py + 8);
      context.stroke();
    }
    if (this.plan.safe_zone) {
      const [px, py] = camera.toScreen(...this.plan.safe_zone.at);
      const radius = Math.max(9, 0.6 * camera.scale);
      context.strokeStyle = palette["person-2"];
      context.setLineDash([4, 3]);
      context.beginPath();
      context.arc(px, py, radius, 0, 2 * Math.PI);
      context.stroke();
      context.setLineDash([]);
    }
  }

  /**
   * Names where they cover nothing: the places first, then the largest obstacles. While all of the floor
   * is shown, none leaves the screen.
   */
  #paintNames({ context, camera, palette }) {
    const taken = [];
    const boxes = new Map(this.obstacles.map(obstacle => [obstacle, this.#onScreen(obstacle.box, camera)]));
    const write = (text, x, y, look, isFree = () => true) => {
      context.font = `${look.weight ?? 400} ${look.size}px ${FONT}`;
      const wide = context.measureText(text).width / 2 + 2;
      const high = look.size / 2 + 1;
      const box = { left: x - wide, right: x + wide, top: y - high, bottom: y + high };
      const isCut = camera.isFitted && common(box, camera.screen) < (box.right - box.left) * (box.bottom - box.top);
      if (isCut || taken.some(other => overlap(other, box)) || !isFree(box)) return false;
      taken.push(box);
      drawText(context, text, x, y, look);
      return true;
    };
    const bold = { color: palette.text, halo: palette.halo, size: camera.scale < SMALL_SCALE ? 10 : 12, weight: 600 };
    const plain = { color: palette.muted, halo: palette.halo, size: 11 };

    for (const { at } of this.plan.stations) {
      const [px, py] = camera.toScreen(...at);
      taken.push({ left: px - 9, right: px + 9, top: py - 9, bottom: py + 9 });
    }
    for (const { name, at } of this.plan.stations) {
      const [px, py] = camera.toScreen(...at);
      const away = Math.max(18, PERSON_RADIUS * camera.scale + 12);      // of a person who stands there
      [[0, away], [0, -away], [away + 26, 0], [-away - 26, 0]]
        .some(([dx, dy]) => write(spoken(name), px + dx, py + dy, bold));
    }
    if (this.plan.safe_zone) {
      const [px, py] = camera.toScreen(...this.plan.safe_zone.at);
      const away = Math.max(9, 0.6 * camera.scale) + 9;
      [away, -away].some(dy => write("safe zone", px, py + dy, bold));
    }
    this.names = taken;
    const writeRound = (words, { left, right, top, bottom }, look, isFree) => {
      const [px, py] = [(left + right) / 2, (top + bottom) / 2];
      const beside = (right - left + textWidth(context, words, { weight: 400, ...look })) / 2 + 5;
      return [[px, bottom + 8], [px, top - 8], [px + beside, py], [px - beside, py]]
        .some(([x, y]) => write(words, x, y, look, isFree));
    };
    const parked = this.plan.lanes.flatMap(({ locations }) => Object.values(locations))
      .map(([x, y]) => this.#onScreen({ left: x - PARKED, right: x + PARKED, bottom: y - PARKED, top: y + PARKED }, camera));
    const named = new Set();     // the groups that have their name
    const largestFirst = [...this.obstacles].sort((a, b) => area(b.box) - area(a.box));
    for (const obstacle of largestFirst) {
      const box = boxes.get(obstacle);
      const [wide, high] = [box.right - box.left, box.bottom - box.top];
      const group = this.groups.find(({ members }) => members.includes(obstacle));
      if ((!group && Math.max(wide, high) < 16) || (obstacle.bottom > 0 && camera.scale < 60)) continue;
      const [px, py] = [(box.left + box.right) / 2, (box.top + box.bottom) / 2];
      const words = spoken(obstacle.name);
      context.font = `400 11px ${FONT}`;
      const length = context.measureText(words).width;
      if (length + 4 <= wide && high >= 13) {
        write(words, px, py, { ...plain, color: palette.text, halo: null });
      } else if (length + 4 <= high && wide >= 13) {
        writeUpwards(context, words, px, py, { ...plain, color: palette.text, halo: null });
        taken.push({ left: px - 7, right: px + 7, top: py - length / 2, bottom: py + length / 2 });
      } else if (Math.min(wide, high) >= 12 || group) {
        if (group && named.has(group)) continue;
        const others = [...boxes.values(), ...parked].filter(other => other !== box);
        const isFree = place => !others.some(other => overlap(other, place));
        if (group) named.add(group);
        writeRound(group ? group.words : words, group ? this.#onScreen(group.box, camera) : box, plain, isFree);
      }
    }
    if (camera.scale < 36) return;
    for (const { locations } of this.plan.lanes) {
      for (const [name, at] of Object.entries(locations)) {
        const [px, py] = camera.toScreen(...at);
        write(spoken(name), px, py + 12, { ...plain, size: 10 });
      }
    }
  }

  #onScreen(box, camera) {
    const [left, bottom] = camera.toScreen(box.left, box.bottom);
    const [right, top] = camera.toScreen(box.right, box.top);
    return { left, right, top, bottom };
  }
}

/** Neighbours whose names differ by a number alone, as {members, box, words}: "bins 1–4". */
function groupsOf(obstacles) {
  const parts = obstacle => /^(.*?)[_ ]?(\d+)$/.exec(obstacle.name);
  const near = (a, b) => a.left - b.right < NEIGHBOUR && b.left - a.right < NEIGHBOUR
    && a.bottom - b.top < NEIGHBOUR && b.bottom - a.top < NEIGHBOUR;
  const groups = [];
  for (const obstacle of obstacles.filter(parts)) {
    const [, stem] = parts(obstacle);
    const own = groups.filter(group => group.stem === stem && group.members.some(other => near(other.box, obstacle.box)));
    const members = [obstacle, ...own.flatMap(group => group.members)];
    for (const group of own) groups.splice(groups.indexOf(group), 1);
    groups.push({ stem, members });
  }
  return groups.filter(({ members }) => members.length > 1).map(({ stem, members }) => {
    const numbers = members.map(member => Number(parts(member)[2])).sort((a, b) => a - b);
    const isRun = numbers.at(-1) - numbers[0] === numbers.length - 1;
    const words = `${spoken(stem)}s ${isRun ? `${numbers[0]}–${numbers.at(-1)}` : numbers.join(", ")}`;
    return { members, words, box: boxOf(members.flatMap(member => member.footprint)) };
  });
}

function writeUpwards(context, text, x, y, look) {
  context.save();
  context.translate(x, y);
  context.rotate(-Math.PI / 2);
  drawText(context, text, 0, 0, look);
  context.restore();
}

function outline(context, camera, ...rings) {
  context.beginPath();
  for (const ring of rings) {
    context.moveTo(...camera.toScreen(...ring[0]));
    for (const [x, y] of ring) context.lineTo(...camera.toScreen(x, y));
    context.closePath();
  }
}

function strokePath(context, camera, points) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(...camera.toScreen(x, y));
  context.stroke();
}

function boxOf(points) {
  const xs = points.map(point => point[0]);
  const ys = points.map(point => point[1]);
  return { left: Math.min(...xs), right: Math.max(...xs), bottom: Math.min(...ys), top: Math.max(...ys) };
}

const area = box => (box.right - box.left) * (box.top - box.bottom);
/** True if two boxes of the screen (y points down) overlap. */
const overlap = (a, b) => common(a, b) > 0;

/** The area that two boxes of the screen share, square pixels. */
const common = (a, b) => Math.max(0, Math.min(a.right, b.right) - Math.max(a.left, b.left))
  * Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));

function isInside(ring, x, y) {
  let inside = false;
  for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
    const [xi, yi] = ring[i];
    const [xj, yj] = ring[j];
    if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) inside = !inside;
  }
  return inside;
}
