// Reads the PNG files that `umbragraph render` writes: 8 bits a channel, red, green, blue and alpha, not interlaced.
import { inflateSync } from "node:zlib";

/** Width, height and texels of a PNG file's bytes. */
export function decode(bytes) {
  if (bytes.readUInt32BE(0) !== 0x89504e47) throw new Error("no PNG file");
  let header = null;
  const data = [];
  for (let at = 8; at < bytes.length; ) {
    const length = bytes.readUInt32BE(at);
    const kind = bytes.toString("latin1", at + 4, at + 8);
    const chunk = bytes.subarray(at + 8, at + 8 + length);
    if (kind === "IHDR") header = chunk;
    if (kind === "IDAT") data.push(chunk);
    at += length + 12;
  }
  const [width, height] = [header.readUInt32BE(0), header.readUInt32BE(4)];
  const channels = { 2: 3, 6: 4 }[header[9]];
  if (header[8] !== 8 || !channels || header[12] !== 0) throw new Error("a PNG file of another kind");
  return { width, height, texels: unfilter(inflateSync(Buffer.concat(data)), width, height, channels) };
}

/** Undoes the filter of each row, and adds an alpha of 255 where there is none. */
function unfilter(rows, width, height, channels) {
  const stride = width * channels;
  const texels = new Uint8Array(width * height * 4).fill(255);
  let above = new Uint8Array(stride);
  for (let y = 0; y < height; y++) {
    const filter = rows[y * (stride + 1)];
    const row = Uint8Array.from(rows.subarray(y * (stride + 1) + 1, (y + 1) * (stride + 1)));
    for (let x = 0; x < stride; x++) {
      const left = x >= channels ? row[x - channels] : 0;
      const corner = x >= channels ? above[x - channels] : 0;
      row[x] += [0, left, above[x], (left + above[x]) >> 1, paeth(left, above[x], corner)][filter];
    }
    for (let x = 0; x < width; x++) {
      texels.set(row.subarray(x * channels, (x + 1) * channels), (y * width + x) * 4);
    }
    above = row;
  }
  return texels;
}

function paeth(left, up, corner) {
  const guess = left + up - corner;
  const [a, b, c] = [left, up, corner].map((one) => Math.abs(guess - one));
  return a <= b && a <= c ? left : b <= c ? up : corner;
}
