//! A document of many passes, which benches share.

use std::fmt::Write as _;

/// Returns a chain of full-screen passes: each reads the output of the previous one.
pub(crate) fn chain(count: usize) -> String {
    let (mut resources, mut passes) = (String::new(), String::new());
    for at in 0..count {
        let last = at + 1 == count;
        let to = if last { "target".to_owned() } else { format!("r{at}") };
        if !last {
            let format = "\"format\": \"rgba8unorm\", \"size\": \"=viewport\"";
            let _ = writeln!(resources, "    \"{to}\": {{ \"texture\": {{ {format} }} }},");
        }
        let shader = match at.checked_sub(1) {
            None => "\"shader\": \"gradient.wgsl.jinja\"".to_owned(),
            Some(before) => format!(
                "\"shader\": \"tonemap.wgsl.jinja\", \"axes\": {{ \"debug_view\": \"shadow_term\" }}, \
                 \"bind\": {{ \"source\": \"&r{before}\" }}"
            ),
        };
        let comma = if last { "" } else { "," };
        let _ = writeln!(
            passes,
            "    \"p{at}\": {{ \"description\": \"one of a chain\", \
             \"fullscreen\": {{ {shader}, \"color\": [{{ \"to\": \"&{to}\" }}] }} }}{comma}"
        );
    }
    let target =
        r#""target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }"#;
    format!(
        "{{\n  \"format\": 1, \"name\": \"chain\",\n  \"resources\": {{\n{resources}    {target}\n  }},\n  \"passes\": {{\n{passes}  }}\n}}\n"
    )
}
