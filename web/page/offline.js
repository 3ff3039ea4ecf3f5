// The page without a network: a service worker (offline_worker.js) keeps what was loaded.

/** Registers the service worker; a browser without one, or a page that is not served securely, needs the network. */
export function keep_offline() {
  navigator.serviceWorker?.register("offline_worker.js").catch(() => {});
}

/** Keeps what the frame needs, once it is drawn: a page that shows no frame does not load it. */
export async function keep_frame(scene) {
  const files = ["painter/umbragraph_web.js", "painter/umbragraph_web_bg.wasm", ...(scene ? [`scenes/${scene}.glb`] : [])];
  const registered = await navigator.serviceWorker?.ready.catch(() => null);
  registered?.active?.postMessage({ keep: files });
}
