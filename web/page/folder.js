// The dialog "Project": a folder to begin with, to take home, or to bring back.
import { download } from "./frame.js";
import { changed, original, own_scenes, take, text_of } from "./texts.js";
import { from_zip, is_pipeline, page_name, to_zip } from "./zip.js";

const $ = (id) => document.getElementById(id);

/** What pipelines name as their schema, for editors. */
const SCHEMA = "pipeline.schema.json";

/** The name of a pipeline's file. */
const stem = (path) => path.replace(/^.*\/|\.jsonc?$/g, "");

/** Something wrong, in the dialog. */
function say(error) {
  $("project-error").hidden = !error;
  $("project-error").textContent = error?.message ?? "";
}

/** Does what a button says, and closes the dialog unless that fails. */
const doing = (work) => async (event) => {
  event.preventDefault();
  try {
    await work();
    $("project").close();
  } catch (error) {
    say(error);
  }
};

/**
 * Connects the dialog. `page.begin(name, kind)` gives the files of a new folder, `page.used()` the files of the pipeline
 * that is shown, the pipeline first, `page.values()` what was set; `page.open(pipeline, scene, values)` opens what is in a
 * folder; `page.write(files)` gives texts to the workers; `page.revert()` takes all changes back. Returns what takes a file that is
 * dropped on the page: a zip, or a scene for `page.take_scene`.
 */
export function listen_to_folder(page) {
  const packed = () => {
    const [pipeline, ...parts] = page.used();
    const texts = [pipeline, ...parts, ...Object.keys(changed), SCHEMA].map((path) => [path, text_of(path)]);
    return [stem(pipeline), Object.fromEntries(texts), [...own_scenes], page.values()];
  };

  /** Takes what is in a folder; a text that is as the page has it is no change. */
  const bring = ({ folder, files, scenes, values }) => {
    Object.entries(files).forEach(([path, text]) => take(path, text));
    scenes.forEach((bytes, name) => own_scenes.set(name, bytes));
    page.write(files);
    const pipelines = Object.keys(files).filter((path) => is_pipeline(path, files[path]));
    const pipeline = pipelines.find((path) => stem(path) === folder) ?? pipelines[0];
    const scene = [...scenes.keys(), ...Object.keys(files).filter((path) => path.endsWith(".gltf"))][0];
    page.open(pipeline, scene, values);
  };

  const bring_zip = (bytes) => {
    let found;
    try {
      found = from_zip(new Uint8Array(bytes));
    } catch (error) {
      throw new Error(`this zip cannot be read: ${error.message}`);
    }
    bring(found);
  };

  $("open-project").onclick = () => {
    say(null);
    const [folder, files] = packed();
    const { length } = Object.keys(files);
    $("project-contents").textContent = `${folder}.zip, ${length} ${length === 1 ? "file" : "files"}`;
    $("project-revert").disabled = !Object.keys(changed).some((path) => original(path) !== undefined);
    $("project").showModal();
  };
  $("project-close").onclick = () => $("project").close();
  $("project-begin").onsubmit = doing(async () => {
    const [name, kind] = [$("project-name").value, $("project-kind").value];
    const files = Object.entries(await page.begin(name, kind)).map(([path, text]) => [page_name(path), text]);
    bring({ folder: name, files: Object.fromEntries(files), scenes: new Map(), values: null });
  });
  $("project-download").onclick = doing(() => {
    const [folder, ...rest] = packed();
    download(new Blob([to_zip(folder, ...rest)], { type: "application/zip" }), `${folder}.zip`);
  });
  $("project-open").onchange = doing(async () => {
    const [file] = $("project-open").files;
    const bytes = await file.arrayBuffer();
    $("project-open").value = "";
    bring_zip(bytes);
  });
  $("project-revert").onclick = doing(page.revert);

  return async (bytes, name) => {
    if (!name.endsWith(".zip")) return page.take_scene(bytes, name);
    try {
      bring_zip(bytes);
    } catch (error) {
      page.notice(error.message);
    }
  };
}
