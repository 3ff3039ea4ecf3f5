// Short texts with `code` in them.
import { element } from "./element.js";

/** The nodes of a text; what is between backticks is code. */
export const words = (text) => text.split("`").map((part, at) => (at % 2 ? element("code", { textContent: part }) : part));
