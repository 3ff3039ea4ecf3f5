// A service worker: files come from the network, and from a cache when there is none.
//
// The network goes first, so that a page that was built again is never mixed with an older one. When the worker is installed
// it keeps what every visit needs; KEPT is that list, written by the build. What the frame needs is kept when it is used.

const CACHE = "umbragraph";

/** Keeps files that are not kept yet. */
async function keep(files) {
  const cache = await caches.open(CACHE);
  await Promise.all(files.map(async (file) => (await cache.match(file)) ?? cache.add(file)));
}

async function answer(request) {
  const cache = await caches.open(CACHE);
  try {
    const response = await fetch(request);
    if (response.ok) await cache.put(request, response.clone());
    return response;
  } catch (error) {
    const kept = await cache.match(request, { ignoreSearch: true });
    if (kept) return kept;
    throw error;
  }
}

self.addEventListener("install", (event) => event.waitUntil(keep(KEPT)));
self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));
self.addEventListener("message", ({ data }) => void keep(data.keep).catch(() => {}));
self.addEventListener("fetch", (event) => {
  const is_ours = event.request.method === "GET" && event.request.url.startsWith(self.registration.scope);
  if (is_ours) event.respondWith(answer(event.request));
});
