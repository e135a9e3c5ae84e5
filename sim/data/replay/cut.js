/* What there is of a recording that was cut off, or is damaged further on. */

const PIECE = 65_536;          // bytes that are unpacked at a time
const CLOSERS = { "{": "}", "[": "]" };
const DEEP = ["motions", "minds"];       // parts of a recording with a list for each name

/** The bytes that base64 stands for, as far as it goes. */
function bytesIn(base64) {
  const sound = /^[A-Za-z0-9+/=\s]*/.exec(base64)[0].replace(/\s/g, "");
  const letters = atob(sound.length === base64.length ? sound : sound.slice(0, sound.length - sound.length % 4));
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

/** The text that bytes are packed from (zlib), as far as they go. */
async function unpacked(bytes) {
  const stream = new DecompressionStream("deflate");
  const [writer, reader, decoder] = [stream.writable.getWriter(), stream.readable.getReader(), new TextDecoder()];
  let text = "";
  const reading = (async () => {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      text += decoder.decode(value, { stream: true });
    }
  })().catch(() => {});        // no more of it can be had
  try {
    for (let at = 0; at < bytes.length; at += PIECE) await writer.write(bytes.subarray(at, at + PIECE));
    await writer.close();
  } catch {
    await writer.abort().catch(() => {});
  }
  await reading;
  return text;
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
