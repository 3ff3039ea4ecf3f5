//! The parameters and features of a pipeline, as a page shows them.

use serde_json::{Map, Value as Json, json};
use umbragraph::low_level::expression::Value;
use umbragraph::low_level::pipeline::TypedPipeline;

/// Converts the parameters and features of a pipeline to JSON, keyed by name: allowed values, description and current
/// value. `live` tells whether a parameter can change between frames without planning again.
pub(crate) fn of_pipeline(pipeline: &TypedPipeline) -> Json {
    let parameters = pipeline.parameters.iter().map(|(name, parameter)| {
        let declared = &parameter.declaration;
        let described = json!({
            "type": declared.parameter_type,
            "min": declared.min,
            "max": declared.max,
            "values": declared.values,
            "unit": declared.unit,
            "description": declared.description,
            "value": to_json(&parameter.value),
            "live": parameter.structural.is_none(),
        });
        (name.clone(), described)
    });
    let features = pipeline.features.iter().map(|(name, feature)| {
        let declared = &feature.declaration;
        let described = json!({
            "values": declared.values,
            "description": declared.description,
            "value": to_json(&feature.value),
        });
        (name.clone(), described)
    });
    json!({ "parameters": parameters.collect::<Map<_, _>>(), "features": features.collect::<Map<_, _>>() })
}

/// Converts the value of a parameter or feature to JSON; a reference, which no parameter holds, becomes `null`.
fn to_json(value: &Value) -> Json {
    match value {
        Value::Bool(on) => Json::from(*on),
        Value::Number(number) => Json::from(*number),
        Value::Text(text) => Json::from(text.as_str()),
        Value::List(list) => list.iter().map(to_json).collect(),
        Value::Reference(_) => Json::Null,
    }
}

/// Converts JSON to the value of a parameter; `None` for objects and `null`, also inside of arrays.
#[cfg(feature = "gpu")]
pub(crate) fn from_json(json: &Json) -> Option<Value> {
    Some(match json {
        Json::Bool(on) => Value::Bool(*on),
        Json::Number(number) => Value::Number(number.as_f64()?),
        Json::String(text) => Value::Text(text.clone()),
        Json::Array(list) => Value::List(list.iter().map(from_json).collect::<Option<_>>()?),
        Json::Null | Json::Object(_) => return None,
    })
}
