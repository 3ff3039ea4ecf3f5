// What was changed, in the address: JSON, compressed, in letters that addresses have. And in the tab, for a reload.

const through = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());

/** The fragment of an address that holds a value. */
export async function pack(value) {
  const bytes = await through(new TextEncoder().encode(JSON.stringify(value)), new CompressionStream("deflate-raw"));
  const letters = btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
  return `#1${letters.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")}`;
}

/** The value in a fragment; nothing where there is none, or a broken one. */
export async function unpack(fragment) {
  if (!fragment.startsWith("#1")) return null;
  try {
    const letters = atob(fragment.slice(2).replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    return JSON.parse(new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw"))));
  } catch {
    return null;
  }
}

const KEY = "umbragraph.changed";

/** Keeps what was changed for a reload of the tab, if the browser keeps anything. */
export function keep(changed) {
  try {
    sessionStorage.setItem(KEY, JSON.stringify(changed));
  } catch {
    // It is lost with the page.
  }
}

/** What was kept. */
export function kept() {
  try {
    return JSON.parse(sessionStorage.getItem(KEY)) ?? {};
  } catch {
    return {};
  }
}
