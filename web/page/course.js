// The course: steps beside the editor, each with a text and tasks that the page checks (course_check.js).
//
// A step is data (course.json): a pipeline, a text, and tasks in order. A task has conditions, and what solves it: edits of
// the step's file or values. Solved tasks stay solved, so that one can be to undo the one before.
import steps from "./course.json";
import { holds } from "./course_check.js";
import { element } from "./element.js";
import { step_address } from "./route.js";
import { words } from "./words.js";

const KEY = "umbragraph.course";

/** The ids of solved steps; a browser that keeps nothing forgets them with the page. */
const solved = new Set((() => {
  try {
    return JSON.parse(localStorage.getItem(KEY)) ?? [];
  } catch {
    return [];
  }
})());

/** Whether a step is solved. */
export const is_solved = (id) => solved.has(id);

/** The step of an id. */
export const step_of = (id) => steps.find((one) => one.id === id);

export class Course {
  #panel;
  #actions;
  #step = null;
  #done = 0;
  #judged = null;

  /** `actions.solve` carries out what solves a task, `actions.reset` brings back the step's files. */
  constructor(panel, actions) {
    [this.#panel, this.#actions] = [panel, actions];
  }

  /** Shows a step, or none. */
  show(step) {
    if (step === this.#step) return;
    [this.#step, this.#done, this.#judged] = [step, 0, null];
    this.#panel.hidden = !step;
    if (step) this.#draw();
    this.#panel.scrollTop = 0;
  }

  /** Looks at an answer of the checker; tasks are solved in their order. */
  judge(answer) {
    const step = this.#step;
    if (!step) return;
    this.#judged = answer;
    const before = this.#done;
    while (this.#done < step.tasks.length && holds(step.tasks[this.#done].check, answer)) this.#done++;
    if (this.#done === before) return;
    if (this.#done === step.tasks.length) this.#remember(step.id);
    this.#draw();
  }

  #remember(id) {
    solved.add(id);
    try {
      localStorage.setItem(KEY, JSON.stringify([...solved]));
    } catch {
      // It is known until the page is left.
    }
  }

  #draw() {
    const step = this.#step;
    const at = steps.indexOf(step);
    const is_done = this.#done === step.tasks.length;
    const had_focus = this.#panel.contains(document.activeElement);
    const option = (one, index) => element("option", {
      value: one.id, selected: one === step, textContent: `${index + 1}  ${one.title}${solved.has(one.id) ? "  ✓" : ""}`,
    });
    const choice = element("select", { ariaLabel: "Step of the course" }, ...steps.map(option));
    choice.onchange = () => (location.hash = step_address(choice.value));
    const bar = element("progress", { max: steps.length, value: steps.filter(({ id }) => solved.has(id)).length, ariaLabel: "Solved steps" });
    const link = (to, textContent, className = "") => to && element("a", { href: step_address(to.id), textContent, className });
    this.#panel.replaceChildren(
      element("div", { className: "where" }, choice, bar),
      element("h2", { textContent: step.title }),
      ...step.text.map((text) => element("p", {}, ...words(text))),
      element("ol", { className: "tasks" }, ...step.tasks.map((task, index) => this.#task(task, index))),
      ...(is_done ? [element("div", { className: "end", role: "status" }, ...step.end.map((text) => element("p", {}, ...words(text))))] : []),
      element("p", { className: "ways" }, ...[
        link(steps[at - 1], "Back"),
        link(steps[at + 1], "Next step", is_done ? "call" : ""),
        steps[at + 1] ? null : element("a", { href: "#", textContent: "To the gallery", className: is_done ? "call" : "" }),
      ].filter(Boolean)),
      element("button", { type: "button", className: "quiet", textContent: "Start this step over", onclick: () => this.#again() }),
    );
    if (had_focus) (this.#panel.querySelector(is_done ? ".call" : ".solve") ?? choice).focus({ preventScroll: true });
  }

  #task(task, index) {
    const is_done = index < this.#done;
    const is_next = index === this.#done;
    const made = element("li", { className: is_done ? "done" : is_next ? "next" : "" }, element("span", {}, ...words(task.text)));
    if (task.code && !is_done) made.append(element("pre", { textContent: task.code }));
    if (is_done) made.prepend(element("span", { className: "hidden", textContent: "Solved: " }));
    if (is_done && task.then) made.append(element("span", { className: "then" }, ...words(task.then)));
    if (is_next) {
      const solve = element("button", { type: "button", className: "solve", textContent: "Do it for me" });
      solve.onclick = () => this.#actions.solve(this.#step, task);
      made.append(solve);
    }
    return made;
  }

  #again() {
    const step = this.#step;
    this.#done = 0;
    this.#actions.reset(step);
    this.#draw();
  }
}
