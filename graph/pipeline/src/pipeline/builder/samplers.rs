//! The settings of samplers.

use crate::pipeline::builder::PassBuilder;
use crate::pipeline::builder::binding::SamplerBind;
use crate::pipeline::settings::evaluate::Evaluate;
use crate::work::{Address, Filter, Sampler};
use umbragraph_text::diagnostic::codes;
use umbragraph_text::language::Expr;

impl PassBuilder<'_> {
    /// Reads the settings of a sampler for a binding of type `kind`; returns `None` after a diagnostic. `wanted` makes
    /// the message for a sampler of the wrong type.
    pub(super) fn sampler(
        &mut self,
        kind: wgpu_types::SamplerBindingType,
        settings: &SamplerBind,
        at: &str,
        wanted: &dyn Fn(&str) -> String,
    ) -> Option<Sampler> {
        let usual = match kind {
            wgpu_types::SamplerBindingType::NonFiltering => Filter::Nearest,
            _ => Filter::Linear,
        };
        let filter = self.word_or(&settings.filter, format_args!("{at}/filter"), usual)?;
        let address = self.word_or(&settings.address, format_args!("{at}/address"), Address::default())?;
        let compare = match &settings.compare {
            Some(word) => Some(self.word(word, &format!("{at}/compare"))?),
            None => None,
        };
        let is_comparison = kind == wgpu_types::SamplerBindingType::Comparison;
        if compare.is_some() != is_comparison {
            let (message, help) = if is_comparison {
                (wanted("a comparison sampler"), "add \"compare\", such as \"less-equal\"")
            } else {
                (wanted("not a comparison sampler"), "remove \"compare\"")
            };
            return self.reject(codes::WRONG_RESOURCE, at, message, help);
        }
        let max_anisotropy = self.anisotropy(settings.max_anisotropy.as_ref(), filter, at)?;
        let lod_clamp = self.lod_clamp(settings, at)?;
        Some(Sampler { filter, address, compare, max_anisotropy, lod_clamp })
    }

    fn anisotropy(&mut self, expr: Option<&Expr>, filter: Filter, at: &str) -> Option<u16> {
        let Some(expr) = expr else { return Some(1) };
        let pointer = format!("{at}/max_anisotropy");
        let count = self.count(expr, &pointer)?;
        if !(1..=16).contains(&count) {
            let message = format!("the anisotropy is {count}");
            return self.reject(codes::OUT_OF_BOUNDS, &pointer, message, "1 to 16 are possible; 1 is none");
        }
        if count > 1 && filter == Filter::Nearest {
            let help = "use the filter \"linear\", or remove \"max_anisotropy\"";
            return self.reject(codes::WRONG_RESOURCE, &pointer, "the nearest texel has no anisotropy", help);
        }
        Some(count as u16)
    }

    fn lod_clamp(&mut self, settings: &SamplerBind, at: &str) -> Option<[u32; 2]> {
        let mut clamp = Sampler::default().lod_clamp;
        for (side, expr, key) in
            [(0, &settings.lod_min_clamp, "lod_min_clamp"), (1, &settings.lod_max_clamp, "lod_max_clamp")]
        {
            let Some(expr) = expr else { continue };
            let pointer = format!("{at}/{key}");
            let value = self.number(expr, &pointer)?;
            if !(0.0..=f64::from(Sampler::MAX_LOD)).contains(&value) {
                let message = format!("a level of detail is {value}");
                let help = format!("0 to {} are possible", Sampler::MAX_LOD);
                return self.reject(codes::OUT_OF_BOUNDS, &pointer, message, help);
            }
            clamp[side] = (value * 1000.0).round() as u32;
        }
        if clamp[0] > clamp[1] {
            let [min, max] = clamp.map(|thousandths| f64::from(thousandths) / 1000.0);
            let message = format!("\"lod_min_clamp\" ({min}) is larger than \"lod_max_clamp\" ({max})");
            let pointer = format!("{at}/lod_min_clamp");
            let help = "raise \"lod_max_clamp\", or lower \"lod_min_clamp\"";
            return self.reject(codes::OUT_OF_BOUNDS, &pointer, message, help);
        }
        Some(clamp)
    }
}
