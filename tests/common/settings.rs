//! Values of parameters in tests.

use serde_json::{Value as Json, json};
use umbragraph::low_level::expression::Value;
use umbragraph::low_level::language::{ParameterDeclaration, ParameterType};

/// Other values that a parameter could have; some may be rejected.
pub fn others(declaration: &ParameterDeclaration, value: &Value) -> Vec<Json> {
    match (declaration.parameter_type, value) {
        (ParameterType::Enum, Value::Text(now)) => {
            declaration.values.iter().filter(|word| *word != now).map(|word| json!(word)).collect()
        }
        (_, Value::Bool(now)) => vec![json!(!now)],
        (ParameterType::F32, Value::Number(now)) => {
            vec![json!(now * 1.5), json!(now * 0.5), json!(now + 0.25), json!(now + 2.0)]
        }
        (_, Value::Number(now)) => {
            [now + 1.0, now * 2.0, now - 1.0, now * 0.5].map(|number| json!(number as i64)).to_vec()
        }
        (_, Value::List(list)) => {
            let scaled = list.iter().filter_map(Value::number).map(|number| number * 0.9).collect::<Vec<_>>();
            let turned =
                list.iter().skip(1).chain(list.first()).filter_map(Value::number).collect::<Vec<_>>();
            let doubled =
                list.iter().filter_map(Value::number).map(|number| number * 2.0).collect::<Vec<_>>();
            vec![json!(scaled), json!(turned), json!(doubled)]
        }
        _ => Vec::new(),
    }
}
