//! Expressions in declarations of resources whose values are needed when a pipeline is loaded.
//!
//! Sizes wait for the plan, since they depend on the size of the frame. Two values cannot wait: the number of frames of
//! a history, since each is a resource, and a computed format (`"format": "=moment_format"`), since shaders are checked
//! against it. Both see parameters, features and derived values.

use crate::pipeline::names::expression_diagnostic::expression_diagnostic;
use crate::pipeline::resource::{Resource, ResourceKind};
use crate::pipeline::state::shared::Shared;
use umbragraph_text::diagnostic::{Diagnostic, codes};
use umbragraph_text::expression::{self, ExpressionError, Value};
use umbragraph_text::language::{Expr, FormatCandidates, Written, parse_format};

/// Evaluates an expression at a JSON pointer within a resource's declaration.
///
/// # Errors
/// Returns a diagnostic, or `None` if the error only follows from another diagnostic.
pub(crate) fn value(
    shared: &Shared,
    resource: &Resource,
    expr: &Expr,
    at: &str,
) -> Result<Value, Option<Box<Diagnostic>>> {
    let value = resource.value.nearest(at);
    let evaluate = || -> Result<Value, ExpressionError> {
        let is_resource = |name: &str| shared.find(name).is_some();
        let expression = expr.parse()?;
        resource.environment.check_words(&expression, &shared.scope)?;
        let expression = resource.environment.close(&expression, &is_resource);
        expression::evaluate(&expression, &shared.scope)
    };
    evaluate().map_err(|mut error| {
        resource.environment.widen(&mut error, std::iter::empty());
        expression_diagnostic(&error, value, &[&resource.pointer, at].concat()).map(Box::new)
    })
}

/// Replaces a format that is an expression with its value. After an error the resource counts as broken.
pub(crate) fn compute_format(shared: &mut Shared, resource: &mut Resource) {
    const AT: &str = "/texture/format";
    let ResourceKind::Texture(texture) = &mut resource.kind else { return };
    let FormatCandidates::One(text) = &mut texture.format else { return };
    let Written::Expression(_) = Written::of(text) else { return };
    let expression = Expr::from(text.as_str());
    let error = match value(shared, resource, &expression, AT) {
        Ok(Value::Text(format)) if parse_format(&format).is_some() => {
            if let ResourceKind::Texture(texture) = &mut resource.kind {
                texture.format = FormatCandidates::One(format);
            }
            return;
        }
        Ok(Value::Text(format)) => {
            let message = format!("the expression yields \"{format}\", which is not a texture format");
            let help = "formats have the names of the WebGPU specification";
            Some(resource.error_at(AT, codes::FORMAT_UNKNOWN, message).help(help))
        }
        Ok(other) => {
            let message = format!("the name of a format is wanted here, this is {}", other.kind_name());
            let help = "make the expression yield a name such as 'rgba16float'";
            Some(resource.error_at(AT, codes::EXPRESSION_TYPE, message).help(help))
        }
        Err(error) => error.map(|error| *error),
    };
    resource.kind = ResourceKind::Broken;
    let environment = resource.environment.clone();
    shared.report_from(error, &environment);
}
