/* A person as a figure that walks. */

const TALL = 1.75;           // metres of the figure as it is drawn here; others are scaled
const STRIDE = 1.3;          // metres of a step with each leg
const EYE_LEVEL = 0.93;      // of the height
const THIGH = 0.44;
const SHIN = 0.42;
const ANKLE = 0.08;
const SLOW = 0.45;           // m/s from which steps are as long as they get

/** How far a body has gone, and how briskly it goes: the phase of its steps. */
class Gait {
  constructor(motion) {
    this.motion = motion;
    this.gone = null;        // metres up to the begin of each piece
  }

  /** {phase (radians), swing from 0 to 1} at t. */
  at(t) {
    const i = Math.max(0, this.motion.upTo(t));
    this.gone ??= this.#sums();
    const gone = this.gone[i] + this.#lengthOf(i, Math.min(Math.max(t, this.motion.begins[i]), this.motion.ends[i]));
    let pace = 0;
    for (let k = -2; k <= 2; k++) pace += this.motion.at(t + 0.1 * k).speed / 5;
    return { phase: (2 * Math.PI * gone) / STRIDE, swing: Math.min(1, pace / SLOW) };
  }

  #sums() {
    const { ends, count } = this.motion;
    const gone = new Float64Array(count + 1);
    for (let i = 0; i < count; i++) gone[i + 1] = gone[i] + this.#lengthOf(i, ends[i]);
    return gone;
  }

  /** The path of a piece up to `end`, metres, by Gauss's rule with three points. */
  #lengthOf(i, end) {
    const begin = this.motion.begins[i];
    const c = this.motion.coefficients;
    const k = 12 * i;
    const speed = u => Math.hypot(
      c[k + 1] + u * (2 * c[k + 2] + 3 * u * c[k + 3]), c[k + 5] + u * (2 * c[k + 6] + 3 * u * c[k + 7]));
    const half = (end - begin) / 2;
    const aside = half * Math.sqrt(0.6);
    return (half / 9) * (5 * speed(half - aside) + 8 * speed(half) + 5 * speed(half + aside));
  }
}

/**
 * A foot in a stride (of which `share` is gone): how far it is `ahead` of the hip (metres), and its `lift` from
 * 0 to 1. In the first half it stands still on the floor, so that it goes back as fast as the body goes on; in
 * the second it comes forward (a cubic with the same speed at both ends).
 */
function stepAt(share) {
  const u = 2 * (share - Math.floor(share));
  if (u < 1) return { ahead: (STRIDE / 4) * (1 - 2 * u), lift: 0 };
  const v = u - 1;
  return { ahead: (STRIDE / 4) * (-1 - 2 * v + 12 * v * v - 8 * v * v * v), lift: Math.sin(Math.PI * v) };
}

/** Puts a person on a pile. */
function addFigure(pile, person, t, color, colors) {
  person.gait ??= new Gait(person.motion);
  const { phase, swing } = person.gait.at(t);
  const { x, y } = person.motion.at(t);
  const scale = (person.height ?? TALL) / TALL;
  const foot = sized(frameAt(x, y, 0, person.motion.heading(t)), scale, scale, scale);
  const put = (shape, frame, l, w, h, own) => pile.add(shape, "solid", sized(frame, l, w, h), own);

  const legs = [1, -1].map(side => {
    const { ahead, lift } = stepAt(phase / (2 * Math.PI) + (side < 0 ? 0.5 : 0));
    const knee = swing * (0.05 + 0.95 * lift);
    return { side, thigh: Math.asin((swing * ahead) / (THIGH + SHIN)) + 0.5 * knee, knee };
  });
  const reachOf = ({ thigh, knee }) => THIGH * Math.cos(thigh) + SHIN * Math.cos(thigh - knee);
  const hip = Math.max(...legs.map(reachOf)) + ANKLE;
  const trousers = mixed(colors.cloth, color, 0.12);
  for (const leg of legs) {
    const joint = swung(shifted(foot, 0, 0.095 * leg.side, hip), leg.thigh);
    put("limb", joint, 0.165, 0.155, THIGH + 0.06, trousers);
    const knee = swung(shifted(joint, 0, 0, -THIGH), -leg.knee);
    put("limb", knee, 0.12, 0.12, SHIN + 0.04, trousers);
    const ankle = swung(shifted(knee, 0, 0, -SHIN), leg.knee - leg.thigh - 0.3 * swing * Math.min(0, leg.thigh));
    put("trunk", shifted(ankle, 0.055, 0, -ANKLE), 0.27, 0.1, 0.11, colors.ink);
  }

  const lean = swung(shifted(foot, 0, 0, hip - 0.07), -0.05 * swing);
  put("trunk", lean, 0.2, 0.31, 0.24, trousers);
  const chest = shifted(lean, 0, 0, 0.13);
  put("trunk", chest, 0.235, 0.4, 0.5, color);
  put("cylinder", shifted(chest, 0, 0, 0.12), 0.226, 0.385, 0.045, colors.stripe);
  put("cylinder", shifted(chest, 0, 0, 0.24), 0.242, 0.405, 0.045, colors.stripe);
  for (const { side, thigh } of legs) {
    const shoulder = leaned(swung(shifted(chest, 0, 0.215 * side, 0.43), -0.75 * thigh), 0.1 * side);
    put("limb", shoulder, 0.11, 0.11, 0.31, color);
    const elbow = swung(shifted(shoulder, 0, 0, -0.27), 0.2 + 0.35 * swing);
    put("limb", elbow, 0.085, 0.085, 0.25, color);
    put("ball", shifted(elbow, 0, 0, -0.27), 0.09, 0.075, 0.12, colors.skin);
  }
  put("cylinder", shifted(chest, 0, 0, 0.46), 0.11, 0.11, 0.12, colors.skin);
  const head = shifted(chest, 0.015, 0, 0.66);
  put("ball", head, 0.2, 0.165, 0.24, colors.skin);
  put("dome", shifted(head, -0.005, 0, 0.01), 0.235, 0.2, 0.14, colors.helmet);
  put("cylinder", shifted(head, 0.03, 0, 0.005), 0.29, 0.21, 0.018, colors.helmet);
}
