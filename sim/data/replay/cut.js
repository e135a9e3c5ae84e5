/* What there is of a recording that was cut off, or is damaged further on. */

const PIECE = 65_536;          // bytes that are unpacked at a time
const CLOSERS = { "{": "}", "[": "]" };
const DEEP = ["motions", "minds"];       // parts of a recording with a list for each name

/** The bytes that base64 stands for, as far as it goes. */
function bytesIn(base64) {
  const letters = lettersIn(base64);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

function lettersIn(base64) {
  try {
    return atob(base64);
  } catch {
    const sound = /^[A-Za-z0-9+/=\s]*/.exec(base64)[0].replace(/\s/g, "");
    return atob(sound.slice(0, sound.length - sound.length % 4));
  }
}

/** What bytes are packed from (zlib), as far as they go: {bytes, isWhole}. */
async function unpacked(packed) {
  const stream = new DecompressionStream("deflate");
  const [writer, reader] = [stream.writable.getWriter(), stream.readable.getReader()];
  const parts = [];
  let isWhole = false;
  const reading = (async () => {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      parts.push(value);
    }
    isWhole = true;
  })().catch(() => {});        // no more of it can be had
  try {
    for (let at = 0; at < packed.length; at += PIECE) await writer.write(packed.subarray(at, at + PIECE));
    await writer.close();
  } catch {
    await writer.abort().catch(() => {});
  }
  await reading;
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return { bytes, isWhole };
}

/**
 * The JSON of a recording up to the last thing in it that is whole, with what was open closed: a part of the
 * recording, an entry of a list in it, a piece of a motion, a thought. Null if there is none.
 */
function wholePart(text) {
  const open = [];
  let [part, whole] = ["", null];
  for (let i = 0; i < text.length; i++) {
    const letter = text[i];
    if (letter === '"') {
      const begin = i + 1;
      for (i++; i < text.length && text[i] !== '"'; i++) if (text[i] === "\\") i++;
      if (open.length === 1) part = text.slice(begin, i);
    } else if (letter in CLOSERS) {
      open.push(letter);
    } else if (letter === "}" || letter === "]") {
      if (CLOSERS[open.pop()] !== letter) break;
      if (open.length <= (DEEP.includes(part) ? 3 : 2)) whole = { end: i + 1, open: [...open] };
    }
  }
  return whole && text.slice(0, whole.end) + whole.open.reverse().map(letter => CLOSERS[letter]).join("");
}
