//! `umbragraph explain`

use umbragraph::diagnostic::suggested_name;

use crate::arguments::ExplainArguments;
use crate::streams::{complain, print};

/// Prints the page of a code, or the list of all; whether there is such a code.
pub(crate) fn run(arguments: &ExplainArguments) -> bool {
    let codes = umbragraph::codes();
    let Some(wanted) = &arguments.code else {
        let list: String = codes.iter().map(|code| format!("{}  {}\n", code.id, code.title)).collect();
        print(&list);
        return true;
    };
    match codes.iter().find(|code| code.id.eq_ignore_ascii_case(wanted)) {
        Some(code) => {
            print(&format!("{}: {}\n\n{}\n", code.id, code.title, code.page));
            true
        }
        None => {
            let suggested = suggested_name(wanted, codes.iter().map(|code| code.id));
            let help =
                suggested.map_or_else(String::new, |suggested| format!(" (did you mean {suggested}?)"));
            complain(&format!("there is no code {wanted}{help}; `umbragraph explain` lists them all\n"));
            false
        }
    }
}
