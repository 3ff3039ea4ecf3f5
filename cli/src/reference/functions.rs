//! The functions of expressions.

use umbragraph::expression::FUNCTIONS;

use super::{Entry, Page};

pub(super) fn page() -> Page {
    let entries = FUNCTIONS.iter().map(|function| Entry {
        name: function.name.to_owned(),
        summary: function.description.to_owned(),
        text: format!("`{}`: {}.", function.usage, function.description),
    });
    Page {
        name: "expressions",
        title: "Expressions",
        introduction: "An expression is a JSON number or boolean, a list of expressions, or a string such as \
            `\"ceil(viewport.width / 16)\"`. Where a setting takes one of several words, or a text, the string is that \
            word; with `=` in front it is an expression which gives one: `\"=reverse_z ? 'greater' : 'less'\"`.\n\n\
            Names are parameters, features, derived values, the variable of `for_each`, the inputs of a subgraph, \
            `viewport` (the size of the picture), and resources: their size, or `.width`, `.height`, `.layers`, `.mips`, \
            `.samples`; of blackboard data the published sizes.\n\n\
            Operators, the weakest first: `a ? b : c`, `||`, `&&`, `== !=`, `< <= > >=`, `+ -`, `* / %`, `! -`, \
            `list[index]`. Arithmetic on a list works element by element. Texts stand in single quotes. \
            What is no finite number is an error at its place.",
        entries: entries.collect(),
    }
}
