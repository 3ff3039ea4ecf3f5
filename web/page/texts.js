// The texts of the page: as they come, and as they were changed.
import { kept } from "./share.js";

/** The pipelines that come with the page, by path. */
export const files = await (await fetch("files.json")).json();

/** What was changed, and what is new: by path, templates by the name that pipelines call them by. */
export const changed = kept();

/** The templates that come with the page, once the checker has told them. */
export const templates = {};

/** Scenes that came in a folder, by name. */
export const own_scenes = new Map();

/** The text as it comes; nothing of what is new. */
export const original = (path) => files[path] ?? templates[path];

/** The text as it is. */
export const text_of = (path) => changed[path] ?? original(path) ?? "";

/** Takes a text. */
export function take(path, text) {
  if (text === original(path)) delete changed[path];
  else changed[path] = text;
}

/** The bytes of a scene that is a text or came in a folder; nothing of the page's own. */
export const scene_bytes = (name) =>
  own_scenes.get(name)?.slice().buffer ?? (name in changed ? new TextEncoder().encode(changed[name]).buffer : null);

/** Names of scenes that are not the page's own. */
export const other_scenes = () => [...own_scenes.keys(), ...Object.keys(changed).filter((path) => path.endsWith(".gltf"))];
