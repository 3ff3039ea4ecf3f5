// What was set: by controls, or in the parameter file that is its text and has a tab of its own.

/** The parameter file's name. */
export const VALUES = "values.json";

export class Values {
  #chosen;
  #typed = null;

  /** `chosen` has the `preset`, the `parameters` and the `features` that were set. */
  constructor(chosen) {
    this.#chosen = chosen;
  }

  /** The parameter file: as it was typed, until a control sets another value. */
  get text() {
    const { preset, parameters, features } = this.#chosen;
    return this.#typed ?? `${JSON.stringify({ format: 1, ...(preset && { preset }), parameters, features }, null, 2)}\n`;
  }

  /** Whether anything was set. */
  get is_set() {
    const { preset, parameters, features } = this.#chosen;
    return Boolean(preset) || [parameters, features].some((set) => Object.keys(set).length);
  }

  /** Takes the file's text; controls follow one that is plain JSON. */
  type(text) {
    this.#typed = text;
    try {
      const { preset = "", parameters = {}, features = {} } = JSON.parse(text);
      Object.assign(this.#chosen, { preset, parameters, features });
    } catch {
      // The diagnostics say what is wrong with it.
    }
  }

  /** Takes values over those that were set. */
  take({ preset = this.#chosen.preset, parameters = {}, features = {} }) {
    this.#typed = null;
    const chosen = this.#chosen;
    Object.assign(chosen, { preset, parameters: { ...chosen.parameters, ...parameters }, features: { ...chosen.features, ...features } });
  }

  /** Begins anew, with a preset or none. */
  clear(preset = "") {
    this.#typed = null;
    Object.assign(this.#chosen, { preset, parameters: {}, features: {} });
  }
}
