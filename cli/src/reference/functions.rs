//! The functions of expressions.

use umbragraph::low_level::expression::FUNCTIONS;

use super::page::{Entry, Page};

pub(super) fn page() -> Page {
    let entries = FUNCTIONS.iter().map(|function| Entry {
        name: function.name.to_owned(),
        summary: function.description.to_owned(),
        text: format!("`{}`: {}.", function.usage, function.description),
    });
    Page {
        name: "expressions",
        title: "Expressions",
        introduction: "The first character of a string says what it is. `\"=ceil(viewport.width / 16)\"` is an expression, \
            `\"&maps\"` or `\"&maps@blur\"` a reference to a resource or to published data, and any other string a word, a \
            file or a declared name, as its key says. Wherever an expression is wanted, a JSON number, a boolean or a list \
            of expressions is one too; wherever a word or a reference is wanted, an expression may yield it: \
            `\"=reverse_z ? 'greater' : 'less'\"`, `\"=soft ? &blurred : &sharp\"`.\n\n\
            Names are parameters, features, derived values, the variable of `for_each`, the inputs of a subgraph, \
            `viewport` (the size of the picture), and resources: their size, or `.width`, `.height`, `.layers`, `.mips`, \
            `.samples`; of blackboard data the published sizes.\n\n\
            Operators, the weakest first: `a ? b : c`, `||`, `&&`, `== !=`, `< <= > >=`, `+ -`, `* / %`, `! -`, \
            `list[index]`. Arithmetic on a list works element by element. Texts stand in single quotes. \
            What is no finite number is an error at its place.",
        entries: entries.collect(),
    }
}
