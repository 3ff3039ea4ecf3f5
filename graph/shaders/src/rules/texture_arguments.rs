//! Arguments of texture functions that WGSL does not take and naga does.
//!
//! Offsets lie between -8 and 7; cubes and textures of one dimension have none; depth is sampled without gradients.
//!
//! Source: *WebGPU Shading Language*, "Texture Built-in Functions".

use naga::{Expression, ImageClass, ImageDimension, Module, SampleLevel, TypeInner};

use super::constant_arguments::Constants;
use crate::codes;
use crate::written::ir;
use crate::written::rejection::Rejection;

/// Returns rejections of texture samples with arguments that WGSL does not allow: invalid offsets, or gradients for
/// depth textures.
pub(crate) fn found(module: &Module) -> Vec<Rejection> {
    let mut found = Vec::new();
    for function in ir::functions(module) {
        let constants = Constants { module, function };
        for (handle, expression) in function.expressions.iter() {
            let Expression::ImageSample { image, offset, level, .. } = expression else { continue };
            let Some(TypeInner::Image { dim, class, .. }) = ir::image(module, function, *image) else {
                continue;
            };
            let mut reject = |message: String, help: &str| {
                let place = function.expressions.get_span(handle);
                found.push(Rejection::new(codes::WGSL_INVALID, message, place).help(help));
            };
            if let Some(offset) = offset {
                let values = constants.values(*offset).unwrap_or_default();
                if matches!(dim, ImageDimension::Cube | ImageDimension::D1) {
                    let message = "a texture of this dimension is sampled without an offset".to_owned();
                    reject(message, "move the coordinates");
                } else if let Some(value) = values.into_iter().find(|value| !(-8.0..=7.0).contains(value)) {
                    let message = format!("the offset {value} is not between -8 and 7");
                    reject(message, "move the coordinates by texels over the texture's size");
                }
            }
            if matches!((level, class), (SampleLevel::Gradient { .. }, ImageClass::Depth { .. })) {
                let message = "a depth texture is sampled without gradients".to_owned();
                reject(message, "use \"textureSampleLevel\"");
            }
        }
    }
    found
}
