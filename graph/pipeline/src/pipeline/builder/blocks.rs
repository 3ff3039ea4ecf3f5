//! The members of a uniform block, each with the expression of its value.

use std::collections::BTreeMap;

use crate::pipeline::builder::PassBuilder;
use crate::pipeline::builder::slots::example;
use crate::pipeline::program::{Program, ProgramBinding};
use crate::pipeline::settings::evaluate::Evaluate;
use crate::work::BlockValues;
use umbragraph_shaders::TypeLayout;
use umbragraph_text::diagnostic::{Diagnostic, codes, suggested_name};
use umbragraph_text::document;
use umbragraph_text::language::Expr;

impl PassBuilder<'_> {
    /// Parses the expressions for members of a block; returns `None` after a diagnostic. If `all` is false, members
    /// without an expression are allowed.
    pub(super) fn block_values(
        &mut self,
        program: &Program,
        binding: &ProgramBinding,
        values: &BTreeMap<String, Expr>,
        at: &str,
        all: bool,
    ) -> Option<BlockValues> {
        let layout = binding.block.as_ref()?;
        let TypeLayout::Struct { members, .. } = layout else {
            let message = "values are bound to a struct";
            let help = "declare the uniform as a struct in the template";
            return self.reject(codes::WRONG_RESOURCE, at, message, help);
        };
        let mut fine = true;
        let mut unknown: Vec<&str> = Vec::new();
        for name in values.keys().filter(|name| !members.iter().any(|member| member.name == **name)) {
            let names: Vec<&str> = members.iter().map(|member| member.name.as_str()).collect();
            let here = document::pointer_join(at, name);
            let member = (binding.name.as_str(), Some(name.as_str()));
            if !self.is_of_another_variant(program, member, &here, &names) {
                unknown.push(name);
                fine = false;
            }
        }
        let mut deferred = Vec::new();
        for member in members {
            let here = document::pointer_join(at, &member.name);
            match values.get(&member.name) {
                Some(expr) => match self.live_deferred(expr, &here) {
                    Some(expression) => deferred.push((member.name.clone(), expression)),
                    None => fine = false,
                },
                None if unknown.iter().any(|name| suggested_name(name, [member.name.as_str()]).is_some()) => {
                    fine = false;
                }
                None if !all => {}
                None => {
                    let message = format!("the member \"{}\" of the block has no value", member.name);
                    let help = format!("add \"{}\": {} here", member.name, example(&member.layout));
                    let declared = program.plain().member(&binding.type_name, &member.name);
                    let diagnostic = Diagnostic::error(codes::UNBOUND, self.place(at), message)
                        .pointer(self.absolute(at))
                        .labelled(declared, "declared here")
                        .help(help);
                    self.shared.diagnostics.push(diagnostic);
                    fine = false;
                }
            }
        }
        fine.then_some(BlockValues { layout: layout.clone(), expressions: deferred })
    }
}
