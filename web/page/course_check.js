// Whether a task of the course is solved, from the last answer about the pipeline.
//
// A task's `check` is a list of conditions, all of which have to hold:
//
//   { "passes": "live" | "culled", "at_least": 2 }     how many passes run, or are left out
//   { "pass": "keep", "is": "live" | "culled" | "absent" }   also its "toggle", or a "setting" that "says" something
//   { "reads": ["show", "painted"] }                   the pass uses the resource; "writes" says the same of writing
//   { "shared": ["sharp", "soft"], "is": false }       two resources are one piece of memory
//   { "resource": "soft", "says": "rgba16float" }      its format and size, as the report has them; also its "frames", or
//                                                      its bytes with "at_least"
//   { "parameter": "divisor", "at_least": 4 }          or "at_most", or "is"; of a list "at" says which number
//   { "feature": "glow", "is": true }
//   { "preset": "low" }
//   { "errors": true }                                 the text is wrong; all other conditions want a plan

const within = (value, { is, at_least = -Infinity, at_most = Infinity }) =>
  is !== undefined ? value === is : value >= at_least && value <= at_most;

const CONDITIONS = {
  passes: ({ report }, one) => within(report.passes.filter((pass) => pass.live === (one.passes === "live")).length, one),
  pass: ({ report }, { pass, is, toggle, setting, says }) => {
    const found = report.passes.find(({ name }) => name === pass);
    if (is && is !== (found ? (found.live ? "live" : "culled") : "absent")) return false;
    if (toggle !== undefined && (found?.toggle ?? null) !== toggle) return false;
    return !setting || Boolean(found?.settings?.[setting]?.includes(says));
  },
  reads: ({ report }, { reads: [pass, resource] }) => report.passes.some(({ name, reads }) => name === pass && reads.includes(resource)),
  writes: ({ report }, { writes: [pass, resource] }) => report.passes.some(({ name, writes }) => name === pass && writes.includes(resource)),
  shared: ({ report }, { shared: [one, other], is }) =>
    report.resources.some(({ name, shares_with }) => name === one && shares_with.includes(other)) === is,
  resource: ({ report }, { resource, says = "", frames, at_least = 0 }) => {
    const found = report.resources.find(({ name }) => name === resource);
    return Boolean(found?.description.includes(says)) && found.bytes >= at_least && (!frames || found.frames === frames);
  },
  parameter: ({ values, settings }, one) => {
    const value = values.parameters[one.parameter] ?? settings.parameters[one.parameter]?.value;
    return within(one.at === undefined ? value : value?.[one.at], one);
  },
  feature: ({ values, settings }, one) => (values.features[one.feature] ?? settings.features[one.feature]?.value) === one.is,
  preset: ({ values }, { preset }) => values.preset === preset,
};

/** Whether all conditions hold of an answer of the checker and the values that were set. */
export function holds(conditions, { plan, diagnostics, values }) {
  const is_wrong = diagnostics.some(({ severity }) => severity === "error");
  return conditions.every((one) => {
    if ("errors" in one) return is_wrong === one.errors;
    const [kind] = Object.keys(one);
    return Boolean(plan) && !is_wrong && CONDITIONS[kind]({ report: plan.report, settings: plan.settings, values }, one);
  });
}
