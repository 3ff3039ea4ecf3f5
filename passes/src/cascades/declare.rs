//! Builds a [`Configuration`] from the settings of a `cascades` pass, with every diagnostic at its place.

use glam::{DVec3, UVec2};
use umbragraph_pipeline::diagnostic::list_of;
use umbragraph_pipeline::expression::Value;
use umbragraph_pipeline::language::Expr;
use umbragraph_pipeline::pipeline::{Evaluate, LiveSettings, PassBuilder};

use super::MAX_CASCADES;
use super::configuration::Configuration;
use super::depth::{LONGEST_REACH, NearPull};
use super::fit::FitShape;
use super::layout::{Layout, LayoutError, MAX_SIDE, Tile};
use super::node::Cascades;
use super::snap::Snap;
use super::splits::{Blend, BlendOf, SplitScheme, Splits};
use crate::codes;
use crate::if_said::if_said;
use crate::lights::described;

/// Evaluates all settings of a `cascades` pass, even after a first error. Returns `None` after at least one diagnostic.
pub(super) fn configuration(settings: &Cascades, pass: &mut PassBuilder<'_>) -> Option<Configuration> {
    let count = settings.splits.as_ref().and_then(|split| split.count.clone());
    let count = if_said(&count, |expr| {
        cascade_count(pass.count(expr, "/splits/count")? as usize, "/splits/count", pass)
    })?;
    let (count, border, live) = pass.live(|pass| live(settings, pass, count));
    let resolutions = resolutions(settings, pass, count, border);
    let layout = match (count, &resolutions) {
        (Some(count), Some(resolutions)) => layout(settings, pass, &resolutions[..count]),
        _ => None,
    };
    Some(Configuration { light: settings.light.clone(), layout: layout?, ..live? })
}

/// Evaluates the live settings again, and updates the configuration; returns `None` after a diagnostic.
pub(super) fn update(
    configuration: &mut Configuration,
    settings: &Cascades,
    pass: &mut LiveSettings<'_>,
) -> Option<()> {
    let (_, _, live) = live(settings, pass, Some(configuration.splits.count()));
    let live = live?;
    let tiles = configuration.layout.tiles.iter().take(live.splits.count());
    let smallest = tiles.map(|tile| tile.resolution).min().unwrap_or(u32::MAX);
    if u64::from(smallest) < 2 * u64::from(live.border) + 2 {
        let message = format!("a cascade of {smallest} texels cannot have a border of {}", live.border);
        return pass.reject(codes::CASCADE_RESOLUTION, "/border", message, "make the border narrower");
    }
    let (light, layout) = (configuration.light.take(), configuration.layout);
    *configuration = Configuration { light, layout, ..live };
    Some(())
}

/// Evaluates the live settings. Returns the number of cascades, the border in texels, and a configuration without light
/// and layout; each is `None` after a diagnostic. `count` is the number of cascades if it is known.
fn live(
    settings: &Cascades,
    pass: &mut impl Evaluate,
    count: Option<usize>,
) -> (Option<usize>, Option<u32>, Option<Configuration>) {
    let splits = splits(settings, pass, count);
    let blend = blend(settings, pass);
    let shape = pass.word_or(&settings.fit, "/fit", FitShape::default());
    let snap = pass.word_or(&settings.snap, "/snap", Snap::default());
    let square = pass.boolean_or(&settings.square_texels, "/square_texels", true);
    let border = pass.count_or(&settings.border, "/border", 2);
    let up = up(settings, pass);
    let near_pull = near_pull(settings, pass);
    let far_extension = if_said(&settings.far_extension, |expr| metres(pass, expr, "/far_extension"));
    let clip_to_scene = pass.boolean_or(&settings.clip_to_scene, "/clip_to_scene", false);
    let reverse = pass.boolean_or(&settings.reverse, "/reverse", false);
    let cadence = described::cadence(pass, &settings.cadence);
    let all = || {
        Some(Configuration {
            light: None,
            layout: Layout::default(),
            splits: splits?,
            blend: blend?,
            shape: shape?,
            snap: snap?,
            square: square?,
            border: border?,
            up: up?,
            near_pull: near_pull?,
            far_extension: far_extension?.unwrap_or(0.0),
            clip_to_scene: clip_to_scene?,
            reverse: reverse?,
            cadence: cadence?,
        })
    };
    (splits.map(|splits| splits.count()), border, all())
}

fn splits(settings: &Cascades, pass: &mut impl Evaluate, count: Option<usize>) -> Option<Splits> {
    let far = pass.numbers(&settings.far, "/far");
    let far = far.and_then(|far| far_distances(far, &settings.far, pass));
    let split = settings.splits.as_ref();
    let scheme = split.and_then(|split| split.scheme.clone());
    let scheme = pass.word_or(&scheme, "/splits/scheme", SplitScheme::default());
    let count = match count {
        Some(count) => Some(count),
        None => far.as_ref().and_then(|far| cascade_count(far.len(), "/far", pass)),
    };
    let near = split.and_then(|split| split.near.as_ref());
    let near = if_said(&near, |expr| pass.number(expr, "/splits/near"));
    let lambda = split.and_then(|split| split.lambda.as_ref());
    let lambda = if_said(&lambda, |expr| {
        fraction(pass, expr, "/splits/lambda", codes::CASCADE_SPLITS, "the weight lambda")
    });
    let (far, scheme, count, near, lambda) = (far?, scheme?, count?, near?, lambda?.unwrap_or(0.5));
    let last = *far.last()?;
    if let Some(near) = near
        && !(near > 0.0 && near < last)
    {
        let message = format!("the splits cannot begin at {near} m and end at {last} m");
        let help = format!("begin above 0 m and before {last} m");
        return pass.reject(codes::CASCADE_SPLITS, "/splits/near", message, help);
    }
    let lambda = match scheme {
        SplitScheme::Explicit => {
            if count > far.len() {
                let message = format!("{count} cascades are wanted, but \"far\" has {} distances", far.len());
                let help = "add far distances, or choose a formula as the scheme";
                return pass.reject(codes::CASCADE_COUNT, "/splits/count", message, help);
            }
            let mut all = [0.0; MAX_CASCADES];
            all[..count].copy_from_slice(&far[..count]);
            return Some(Splits::Explicit { far: all, count });
        }
        SplitScheme::Whole => return Some(Splits::Whole { count }),
        SplitScheme::Uniform => 0.0,
        SplitScheme::Logarithmic => 1.0,
        SplitScheme::Practical => lambda,
    };
    // A parameter may be meant for several schemes, one of them at a time; a list that is written here is not.
    if far.len() > 1 && settings.far.0.is_array() {
        let listed: Vec<String> = far[..far.len() - 1].iter().map(f64::to_string).collect();
        let message =
            format!("a formula computes all distances but the last: {} m have no effect", list_of(listed));
        let help = format!("write \"far\": [{last}] and \"count\": {count}, or the scheme \"explicit\"");
        pass.warn(codes::CASCADE_SPLITS, "/far", message, help);
    }
    Some(Splits::Formula { lambda, near, far: last, count })
}

/// Returns the far distances, in metres, if they are positive, finite and increasing after rounding to 32 bits. Returns
/// `None` after a diagnostic.
fn far_distances(far: Vec<f64>, far_setting: &Expr, pass: &mut impl Evaluate) -> Option<Vec<f64>> {
    let mut before = 0.0_f32;
    for (at, distance) in far.iter().enumerate() {
        let rounded = *distance as f32;
        if !rounded.is_finite() || rounded <= before {
            let message = match at {
                0 => format!("the far distance {distance} m is not above zero"),
                _ => format!(
                    "the far distance {distance} m does not lie beyond the {} m before it",
                    far[at - 1]
                ),
            };
            let help = "far distances are metres above zero, each greater than the one before";
            return pass.reject(codes::CASCADE_FAR, &element(far_setting, "/far", at), message, help);
        }
        before = rounded;
    }
    Some(far)
}

fn cascade_count(count: usize, pointer: &str, pass: &mut impl Evaluate) -> Option<usize> {
    if (1..=MAX_CASCADES).contains(&count) {
        return Some(count);
    }
    let message = format!("{count} cascades are requested, 1 to {MAX_CASCADES} can be fitted");
    let help = "change the number of far distances, or \"count\"";
    pass.reject(codes::CASCADE_COUNT, pointer, message, help)
}

fn blend(settings: &Cascades, pass: &mut impl Evaluate) -> Option<Blend> {
    let Some(blend) = &settings.blend else { return Some(Blend::default()) };
    let fraction = fraction(pass, &blend.fraction, "/blend/fraction", codes::CASCADE_BLEND, "the blend zone");
    let of = pass.word_or(&blend.of, "/blend/of", BlendOf::default());
    Some(Blend { fraction: fraction?, of: of? })
}

fn up(settings: &Cascades, pass: &mut impl Evaluate) -> Option<DVec3> {
    let Some(expr) = &settings.up else { return Some(DVec3::Y) };
    let numbers = pass.numbers(expr, "/up")?;
    let up = <[f64; 3]>::try_from(numbers).ok().map(DVec3::from).and_then(DVec3::try_normalize);
    up.or_else(|| {
        let message = "the up vector has no direction";
        let help = "write three numbers that are not all zero: [0, 1, 0]";
        pass.reject(codes::LIGHT_UP, "/up", message, help)
    })
}

fn near_pull(settings: &Cascades, pass: &mut impl Evaluate) -> Option<NearPull> {
    let named = |word: &str| match word {
        "casters" => Some(NearPull::Casters),
        "scene" => Some(NearPull::Scene),
        _ => None,
    };
    let expr = match &settings.near_pull {
        None => return Some(NearPull::Casters),
        Some(Expr(serde_json::Value::String(word))) if named(word).is_some() => return named(word),
        Some(expr) => expr,
    };
    match pass.value(expr, "/near_pull")? {
        Value::Text(word) if named(&word).is_some() => named(&word),
        Value::Text(word) => {
            let message = format!("the near plane cannot be pulled to \"{word}\"");
            let help = "write \"casters\", \"scene\", or a number of metres from 0";
            pass.reject(codes::CASCADE_DEPTH, "/near_pull", message, help)
        }
        _ => metres(pass, expr, "/near_pull").map(NearPull::Metres),
    }
}

fn resolutions(
    settings: &Cascades,
    pass: &mut PassBuilder<'_>,
    count: Option<usize>,
    border: Option<u32>,
) -> Option<[u32; MAX_CASCADES]> {
    let numbers = pass.numbers(&settings.resolution, "/resolution")?;
    let (count, border) = (count?, border?);
    if numbers.len() != 1 && numbers.len() < count {
        let message = format!("there are {count} cascades, but {} resolutions", numbers.len());
        let help = "write one number for all, or one for each";
        return pass.reject(codes::CASCADE_RESOLUTION, "/resolution", message, help);
    }
    let min = 2.0 * f64::from(border) + 2.0;
    let mut all = [0; MAX_CASCADES];
    for (at, resolution) in all.iter_mut().enumerate().take(count) {
        let (number, pointer) = match numbers.as_slice() {
            [one] => (*one, "/resolution".to_owned()),
            several => (several[at], element(&settings.resolution, "/resolution", at)),
        };
        if number.fract() != 0.0 || !(min..=f64::from(MAX_SIDE)).contains(&number) {
            let message =
                format!("a cascade cannot have a resolution of {number} texels with a border of {border}");
            let help = format!("write a whole number from {min} to {MAX_SIDE}");
            return pass.reject(codes::CASCADE_RESOLUTION, &pointer, message, help);
        }
        *resolution = number as u32;
    }
    Some(all)
}

fn layout(settings: &Cascades, pass: &mut PassBuilder<'_>, resolutions: &[u32]) -> Option<Layout> {
    let map = if_said(&settings.map, |expr| {
        let numbers = pass.numbers(expr, "/map")?;
        let size = texels(&numbers).filter(|size| size.cmpgt(UVec2::ZERO).all());
        size.or_else(|| {
            let message = "the size of the map is no width and height in texels";
            let help = "write two whole numbers above zero: [2048, 2048]";
            pass.reject(codes::CASCADE_TILE, "/map", message, help)
        })
    })?;
    let layout = match &settings.tiles {
        None => Layout::layers(resolutions, map),
        Some(expr) => Layout::tiles(resolutions, &origins(expr, pass, resolutions.len())?, map),
    };
    let errors = layout.errors(resolutions.len());
    for error in &errors {
        let (tile, message, help) = match error {
            LayoutError::Outside { tile } => {
                let (end, map) = (layout.tiles[*tile].end(), layout.map);
                let message = format!(
                    "cascade {tile} reaches to texel ({}, {}) of a map of {} × {}",
                    end.x, end.y, map.x, map.y
                );
                (*tile, message, "move the tile, or make the map larger".to_owned())
            }
            LayoutError::Overlap { first, second } => {
                let tile = |at: usize| {
                    let Tile { origin, resolution, .. } = layout.tiles[at];
                    format!("{at} ({resolution} texels from [{}, {}])", origin.x, origin.y)
                };
                let message = format!("the tiles of cascades {} and {} overlap", tile(*first), tile(*second));
                (*second, message, format!("move one of them by {} texels", layout.tiles[*second].resolution))
            }
        };
        let pointer =
            settings.tiles.as_ref().map_or_else(|| "/map".to_owned(), |tiles| element(tiles, "/tiles", tile));
        pass.report(codes::CASCADE_TILE, &pointer, message, help);
    }
    errors.is_empty().then_some(layout)
}

/// Evaluates the upper left texels of the tiles: a list of [x, y], or a flat list of x, y, x, y and so on. Returns
/// `None` after a diagnostic.
fn origins(expr: &Expr, pass: &mut PassBuilder<'_>, count: usize) -> Option<Vec<UVec2>> {
    let value = pass.value(expr, "/tiles")?;
    let origins: Option<Vec<UVec2>> = match &value {
        Value::List(pairs) if pairs.iter().all(|pair| matches!(pair, Value::List(_))) => {
            pairs.iter().map(|pair| texels(&pair.numbers()?)).collect()
        }
        flat => flat.numbers().and_then(|numbers| numbers.chunks(2).map(texels).collect()),
    };
    let message = match &origins {
        None => "a tile is no [x, y] of whole texels".to_owned(),
        Some(origins) if origins.len() < count => {
            format!("there are {count} cascades, but {} tiles", origins.len())
        }
        Some(_) => return origins,
    };
    let help = "write the upper left texel of each tile: [[0, 0], [1024, 0]]";
    pass.reject(codes::CASCADE_TILE, "/tiles", message, help)
}

/// The JSON pointer of element `at` if the document writes the list as an array; else the pointer of the expression for
/// the list.
fn element(list: &Expr, pointer: &str, at: usize) -> String {
    match &list.0 {
        serde_json::Value::Array(_) => format!("{pointer}/{at}"),
        _ => pointer.to_owned(),
    }
}

/// Returns two numbers as texels; `None` unless they are exactly two integers from 0 to [`MAX_SIDE`].
fn texels(numbers: &[f64]) -> Option<UVec2> {
    let whole = |number: f64| {
        (number.fract() == 0.0 && (0.0..=f64::from(MAX_SIDE)).contains(&number)).then_some(number as u32)
    };
    match numbers {
        [x, y] => Some(UVec2::new(whole(*x)?, whole(*y)?)),
        _ => None,
    }
}

fn metres(pass: &mut impl Evaluate, expr: &Expr, pointer: &str) -> Option<f64> {
    let metres = pass.number(expr, pointer)?;
    if (0.0..=LONGEST_REACH).contains(&metres) {
        return Some(metres);
    }
    let message = format!("the depth range cannot be extended by {metres} m");
    let help = format!("write a number of metres from 0 to {LONGEST_REACH}");
    pass.reject(codes::CASCADE_DEPTH, pointer, message, help)
}

fn fraction(
    pass: &mut impl Evaluate,
    expr: &Expr,
    pointer: &str,
    code: umbragraph_pipeline::diagnostic::Code,
    what: &str,
) -> Option<f64> {
    let fraction = pass.number(expr, pointer)?;
    if (0.0..=1.0).contains(&fraction) {
        return Some(fraction);
    }
    let message = format!("{what} is {fraction}, which is not a fraction");
    let help = "write a number from 0 to 1";
    pass.reject(code, pointer, message, help)
}
