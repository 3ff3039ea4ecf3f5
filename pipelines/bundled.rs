//! The pipelines that come with this crate: `"extends": "umbragraph:nebula.json"` works wherever a pipeline lies.
//!
//! Their names, which begin with `umbragraph:`, are paths like others: what they extend themselves is relative to them,
//! and diagnostics name them so. A file of such a name on the disk is not looked for.

use std::path::Path;

use crate::diagnostic::{Diagnostic, codes, list_of, suggested_name};
use crate::low_level::compose::Files;
use crate::low_level::source::{FileId, Sources};

/// The scheme with which the names of bundled files begin.
pub(crate) const SCHEME: &str = "umbragraph:";

/// Every bundled file: its name behind `umbragraph:`, and its text; sorted by name.
pub const PIPELINES: &[(&str, &str)] = &[
    ("awsm.json", include_str!("awsm.json")),
    ("awsm/casters.json", include_str!("awsm/casters.json")),
    ("awsm/clustered_lights.json", include_str!("awsm/clustered_lights.json")),
    ("awsm/debug_views.json", include_str!("awsm/debug_views.json")),
    ("awsm/deferred.json", include_str!("awsm/deferred.json")),
    ("awsm/depth_bounds.json", include_str!("awsm/depth_bounds.json")),
    ("awsm/directional_lights.json", include_str!("awsm/directional_lights.json")),
    ("awsm/filters.json", include_str!("awsm/filters.json")),
    ("awsm/lights.json", include_str!("awsm/lights.json")),
    ("awsm/moments.json", include_str!("awsm/moments.json")),
    ("awsm/rays.json", include_str!("awsm/rays.json")),
    ("awsm/screen_visibility.json", include_str!("awsm/screen_visibility.json")),
    ("awsm/shading.json", include_str!("awsm/shading.json")),
    ("base/cascades.json", include_str!("base/cascades.json")),
    ("base/fitted_cascades.json", include_str!("base/fitted_cascades.json")),
    ("base/forward.json", include_str!("base/forward.json")),
    ("base/hemisphere.json", include_str!("base/hemisphere.json")),
    ("base/scene_geometry.json", include_str!("base/scene_geometry.json")),
    ("base/tiled_cascades.json", include_str!("base/tiled_cascades.json")),
    ("caracal.json", include_str!("caracal.json")),
    ("effects/auto_exposure.json", include_str!("effects/auto_exposure.json")),
    ("effects/bloom.json", include_str!("effects/bloom.json")),
    ("effects/depth_of_field.json", include_str!("effects/depth_of_field.json")),
    ("effects/film.json", include_str!("effects/film.json")),
    ("effects/gtao.json", include_str!("effects/gtao.json")),
    ("effects/taa.json", include_str!("effects/taa.json")),
    ("extended/awsm_deferred.json", include_str!("extended/awsm_deferred.json")),
    ("extended/lore_evsm.json", include_str!("extended/lore_evsm.json")),
    ("extended/lore_local_lights.json", include_str!("extended/lore_local_lights.json")),
    ("extended/lore_pcss.json", include_str!("extended/lore_pcss.json")),
    ("extended/lore_temporal.json", include_str!("extended/lore_temporal.json")),
    ("extended/lore_vsm.json", include_str!("extended/lore_vsm.json")),
    ("lore.json", include_str!("lore.json")),
    ("mantis.json", include_str!("mantis.json")),
    ("nebula.json", include_str!("nebula.json")),
    ("parts/blur.json", include_str!("parts/blur.json")),
    ("parts/blur_tiles.json", include_str!("parts/blur_tiles.json")),
    ("parts/cached_casters.json", include_str!("parts/cached_casters.json")),
    ("parts/environment.json", include_str!("parts/environment.json")),
    ("parts/mips.json", include_str!("parts/mips.json")),
    ("umbra.json", include_str!("umbra.json")),
    ("umbra/environment.json", include_str!("umbra/environment.json")),
    ("umbra/fog.json", include_str!("umbra/fog.json")),
    ("umbra/picture.json", include_str!("umbra/picture.json")),
];

/// The bundled files, and where all others come from.
#[derive(Clone, Debug)]
pub struct Bundled<F>(pub F);

impl<F> Bundled<F> {
    /// Whether a path is the name of a bundled file.
    pub(crate) fn has(path: &Path) -> bool {
        path.to_string_lossy().starts_with(SCHEME)
    }
}

impl<F: Files> Files for Bundled<F> {
    fn has_scheme(&self, scheme: &str) -> bool {
        SCHEME.strip_suffix(':') == Some(scheme) || self.0.has_scheme(scheme)
    }

    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        let name = path.to_string_lossy().replace('\\', "/");
        let Some(bundled) = name.strip_prefix(SCHEME).map(|name| name.trim_start_matches('/')) else {
            return self.0.read(path, sources).map_err(|diagnostic| {
                // The ending makes no name like another.
                let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                let known: Vec<String> = PIPELINES.iter().map(|(known, _)| stem(Path::new(known))).collect();
                let name = stem(path);
                let exact = known.iter().map(String::as_str).find(|known| *known == name);
                let meant = exact.or(suggested_name(&name, known.iter().map(String::as_str)));
                let at = meant.and_then(|meant| known.iter().position(|known| known == meant));
                let is_open = diagnostic.code == codes::FILE_UNREADABLE && !diagnostic.has_suggestion();
                match at.filter(|_| is_open) {
                    Some(at) => diagnostic.help(format!("did you mean \"{SCHEME}{}\"?", PIPELINES[at].0)),
                    None => diagnostic,
                }
            });
        };
        match PIPELINES.iter().find(|(known, _)| *known == bundled) {
            Some((_, text)) => Ok(sources.add(format!("{SCHEME}{bundled}"), *text)),
            None => {
                let message = format!("no file \"{bundled}\" comes with this version");
                let name = format!("{SCHEME}{bundled}");
                let known = || PIPELINES.iter().map(|(known, _)| *known);
                let help = match suggested_name(bundled, known()) {
                    Some(suggested) => format!("did you mean \"{SCHEME}{suggested}\"?"),
                    None => format!("there are {}", list_of(known())),
                };
                Err(Diagnostic::in_file(codes::FILE_UNREADABLE, &name, "", message).help(help))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::PIPELINES;

    #[test]
    fn every_pipeline_beside_this_file_is_bundled() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines");
        let mut found = Vec::new();
        for prefix in ["", "awsm/", "base/", "effects/", "extended/", "parts/", "umbra/"] {
            for entry in std::fs::read_dir(folder.join(prefix)).unwrap().flatten() {
                let name = entry.file_name().to_string_lossy().into_owned();
                if name.ends_with(".json") {
                    found.push(format!("{prefix}{name}"));
                }
            }
        }
        found.sort();
        assert_eq!(PIPELINES.iter().map(|(name, _)| *name).collect::<Vec<_>>(), found);
    }
}
