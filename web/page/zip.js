// A folder of files as a zip: what one takes home from the page, and brings back.
//
// In the page, a template has the name by which pipelines call it. In a folder it lies below `shaders/`, where
// `umbragraph check FILE --templates shaders` finds it. `values.json` holds what was set by hand, as a parameter file.
import { strFromU8, strToU8, unzipSync, zipSync } from "fflate";
import { VALUES } from "./values.js";

const FOLDER = "shaders/";
/** The largest file that is read from a zip, and the largest sum, in bytes. */
const LARGEST = 64 << 20;
const LARGEST_SUM = 256 << 20;
/** A zip keeps times; these files have none. */
const TIME = new Date(1980, 0, 1);

const is_template = (path) => /\.(jinja|axes\.json)$/.test(path);
const is_text = (path) => /\.(jsonc?|jinja|md|ya?ml|gltf|txt|wgsl)$/.test(path);
const is_scene = (path) => path.endsWith(".glb");

/** Whether a text is a pipeline that can be opened: it has a format and passes, and no other kind of file has both. */
export const is_pipeline = (path, text) =>
  /\.jsonc?$/.test(path) && !/\.(axes|schema|params)\.json$/.test(path) && /"passes"\s*:/.test(text) && /"format"\s*:\s*1/.test(text);

/** The name in the page of a file of a folder. */
export const page_name = (path) => (is_template(path) ? path.replace(/^(.*\/)?shaders\//, "") : path);

/** The zip of a folder: texts and scenes by path, and the parameter file of what was set. */
export function to_zip(folder, files, scenes, values) {
  const entries = Object.entries(files).map(([path, text]) => [is_template(path) ? FOLDER + path : path, strToU8(text)]);
  if (values) entries.push([VALUES, strToU8(values)]);
  entries.push(...scenes);
  entries.sort(([one], [other]) => (one < other ? -1 : 1));
  const named = entries.map(([path, bytes]) => [`${folder}/${path}`, bytes]);
  return zipSync(Object.fromEntries(named), { mtime: TIME, level: 9 });
}

/** What is in a zip: the folder's name, `files`, `scenes`, and `values` if there are some. Other files are left out. */
export function from_zip(bytes) {
  let sum = 0;
  const read = unzipSync(bytes, {
    filter: ({ name, originalSize }) => {
      if (!(is_text(name) || is_scene(name))) return false;
      sum += originalSize;
      if (originalSize > LARGEST || sum > LARGEST_SUM) throw new Error(`${name} has ${originalSize} bytes, more than the page takes`);
      return true;
    },
  });
  const paths = Object.keys(read);
  if (!paths.length) throw new Error("the zip holds no pipelines, templates or scenes");
  const [first] = paths[0].split("/", 1);
  const folder = paths.every((path) => path.startsWith(`${first}/`)) ? first : "";
  const found = { folder, files: {}, scenes: new Map(), values: null };
  for (const path of paths.sort()) {
    const inside = folder ? path.slice(folder.length + 1) : path;
    if (is_scene(inside)) found.scenes.set(inside, read[path]);
    else if (inside === VALUES) found.values = strFromU8(read[path]);
    else found.files[page_name(inside)] = strFromU8(read[path]);
  }
  return found;
}
