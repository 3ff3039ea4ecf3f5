//! A report on a plan and its graph, as a value.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::visit::EdgeRef as _;
use serde::{Deserialize, Serialize};

use super::settings::settings;
use crate::why::{why_culled, why_kept};
use umbragraph_compiler::{
    Edge, Graph, GraphNode, Hazard, Physical, Plan, StoreOperation, surviving_writers,
};
use umbragraph_pipeline::language::{Lifetime, format_name};
use umbragraph_pipeline::pipeline::{ResourceKind, SubresourceRange};
use umbragraph_pipeline::source::{Sources, Span};
use umbragraph_pipeline::work::{LoadOperation, PassHandle, ResourceHandle, Work};

/// The maximum number of steps listed for the reason of one pass; caps the report's growth for long chains of passes.
pub const MAX_STEPS: usize = 16;

/// A plan as serializable data, from which JSON, SVG, HTML, Graphviz and Mermaid output is made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Report {
    /// The name of the pipeline.
    pub pipeline: String,
    /// The width and height of the rendered image in texels.
    pub viewport: [u32; 2],
    /// The name of the objective by which passes were ordered, such as `memory`.
    pub objective: String,
    /// All passes: the live ones in execution order, each culled one at the place where it would run. A pass's index in
    /// this list is its column.
    pub passes: Vec<PassReport>,
    /// All resources that a pass uses, in the order of the pipeline.
    pub resources: Vec<ResourceReport>,
    /// The dependency edges between passes.
    pub edges: Vec<EdgeReport>,
    /// The memory that the plan needs, in bytes.
    pub memory: MemoryReport,
}

/// One pass of the pipeline, live or culled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PassReport {
    /// The name of the pass.
    pub name: String,
    /// The name of the node kind that made the pass.
    pub kind: String,
    /// The type of work: `cpu`, `draw`, `compute`, `copy` or `nothing`.
    pub work: String,
    /// Whether the pass runs; `false` if it is culled.
    pub live: bool,
    /// The number of the render pass group, shared by passes merged into one render pass; `None` for a culled pass.
    pub group: Option<usize>,
    /// The toggle that must be on for the pass to run, or off if the name has a "!" prefix; `None` if it always runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub toggle: Option<String>,
    /// The fallbacks that readers get in frames in which this pass is off, each as "FALLBACK in place of RESOURCE".
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub passthrough: Vec<String>,
    /// The reason why the pass is kept or culled, one step per entry, at most [`MAX_STEPS`] and a note that there are
    /// more.
    pub why: Vec<String>,
    /// The names of the resources that the pass reads.
    pub reads: Vec<String>,
    /// The names of the resources that the pass writes.
    pub writes: Vec<String>,
    /// The color, depth and stencil attachments; empty for a culled pass.
    pub attachments: Vec<AttachmentReport>,
    /// Further settings by name, as text: attachments, draws, bindings with their values, and copies.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub settings: BTreeMap<String, String>,
    /// The workgroup counts in x, y and z; `None` unless the pass is a live compute pass with known counts.
    pub workgroups: Option<[u32; 3]>,
    /// The shader variants of the pass in words.
    pub variants: Vec<String>,
    /// The source location of the declaration, as `FILE:LINE`.
    pub declared: String,
}

/// One attachment of a pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct AttachmentReport {
    /// The name of the attached resource.
    pub resource: String,
    /// The kind of attachment: `color`, `depth` or `stencil`.
    pub kind: String,
    /// The load operation: `load`, `clear` or `discard`.
    pub load: String,
    /// The store operation: `store` or `discard`.
    pub store: String,
    /// Whether the attachment never leaves the pass: not loaded, not stored and used nowhere else.
    pub transient_attachment: bool,
}

/// One resource that a pass uses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ResourceReport {
    /// The name of the resource.
    pub name: String,
    /// The kind of resource: `texture`, `buffer` or `data` (CPU data).
    pub kind: String,
    /// The lifetime of the contents: one frame, kept from frame to frame, or owned by the host.
    pub lifetime: Lifetime,
    /// Whether a live pass uses the resource.
    pub live: bool,
    /// The format and size in words; empty for CPU data or a resource that no live pass uses.
    pub description: String,
    /// The size in bytes; 0 for a resource that no live pass uses.
    pub bytes: u64,
    /// The physical resource, such as `texture 3`; resources with the same place share memory. Otherwise `imported`,
    /// `blackboard` (CPU data), or `nowhere` for a resource that no live pass uses.
    pub place: String,
    /// The names of the other resources that share this one's memory.
    pub shares_with: Vec<String>,
    /// The columns (indices in `Report::passes`) of the first and last pass that use the resource.
    pub columns: [usize; 2],
    /// The columns (indices in `Report::passes`) of the passes that read the resource.
    pub read_in: Vec<usize>,
    /// The columns (indices in `Report::passes`) of the passes that write the resource.
    pub written_in: Vec<usize>,
    /// The number of earlier frames that can be read; `None` unless the resource is a history.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<u32>,
    /// The source location of the declaration, as `FILE:LINE`.
    pub declared: String,
}

/// The reason why one pass must run before another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EdgeKind {
    /// The later pass reads a version that the earlier pass writes.
    Data,
    /// The later pass overwrites contents that the earlier pass reads.
    WriteAfterRead,
    /// The later pass overwrites contents that the earlier pass writes.
    WriteAfterWrite,
    /// The pipeline document declares the order with `after`.
    Explicit,
    /// The second pass reads, some frames later, the contents that the first leaves in a history. No order within a
    /// frame follows.
    LaterFrame,
}

/// A dependency edge from one pass to another.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[non_exhaustive]
pub struct EdgeReport {
    /// The column (index in `Report::passes`) of the first pass.
    pub from: usize,
    /// The column (index in `Report::passes`) of the second pass.
    pub to: usize,
    /// The kind of dependency.
    pub kind: EdgeKind,
    /// The name of the resource that causes the edge; `None` for an explicit order.
    pub resource: Option<String>,
    /// For a data edge, the version number (from 1) and its subresource range; `None` for other edges.
    pub version: Option<String>,
}

/// The memory that a plan needs, in bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MemoryReport {
    /// The bytes needed if no two resources shared memory.
    pub without_aliasing: u64,
    /// The bytes of all created textures and buffers.
    pub created: u64,
    /// The lower bound for this pass order in bytes: the peak of live bytes of each compatibility class, summed.
    pub bound: u64,
    /// The maximum number of bytes alive at once over all compatibility classes.
    pub peak: u64,
    /// For the objective `memory`, three byte counts: in document order, in the chosen order, and the lower bound of
    /// all orders. `None` for other objectives.
    pub orders: Option<[u64; 3]>,
    /// The bytes alive in each column (index in `Report::passes`).
    pub alive: Vec<u64>,
    /// The compatibility classes: groups of resources that can share memory.
    pub classes: Vec<CompatibilityClassReport>,
}

/// One compatibility class: resources that can share memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CompatibilityClassReport {
    /// The common properties of the resources in words.
    pub description: String,
    /// The number of resources in the class.
    pub resources: usize,
    /// The number of physical textures or buffers created for the class.
    pub created: usize,
    /// The total bytes created for the class.
    pub bytes: u64,
}

impl Report {
    /// Builds the report of a plan and its graph.
    pub fn new(plan: &Plan, graph: &Graph, sources: &Sources) -> Self {
        let columns = columns(plan, graph);
        let mut column_of = vec![0; plan.pipeline.passes.len()];
        for (column, pass) in columns.iter().enumerate() {
            column_of[pass.index()] = column;
        }
        let passes = columns.iter().map(|pass| pass_report(plan, sources, *pass)).collect();
        let resources = resources(plan, sources, &columns);
        let alive = alive(&resources, columns.len());
        let orders = plan.order.memory.map(|memory| [memory.declaration, memory.chosen, memory.bound]);
        Self {
            pipeline: plan.name.clone(),
            viewport: plan.viewport,
            objective: plan.order.objective.name().to_owned(),
            passes,
            edges: edges(plan, graph, &column_of),
            memory: MemoryReport {
                without_aliasing: plan.bytes_without_aliasing,
                created: plan.bytes,
                bound: plan.bytes_bound,
                peak: plan.bytes_peak,
                orders,
                alive,
                classes: classes(plan),
            },
            resources,
        }
    }

    /// Returns the number of live passes.
    pub fn live_passes(&self) -> usize {
        self.passes.iter().filter(|pass| pass.live).count()
    }
}

/// Returns the live passes in execution order, each culled one after the live pass that it would follow.
fn columns(plan: &Plan, graph: &Graph) -> Vec<PassHandle> {
    let mut behind: BTreeMap<Option<PassHandle>, Vec<PassHandle>> = BTreeMap::new();
    let mut last = None;
    for pass in &graph.order {
        if plan.position(*pass).is_some() {
            last = Some(*pass);
        } else {
            behind.entry(last).or_default().push(*pass);
        }
    }
    let mut columns = behind.remove(&None).unwrap_or_default();
    for planned in &plan.passes {
        columns.push(planned.handle);
        columns.extend(behind.remove(&Some(planned.handle)).unwrap_or_default());
    }
    columns
}

fn place_of(sources: &Sources, span: Span) -> String {
    sources
        .get(span.file)
        .map_or_else(String::new, |file| format!("{}:{}", file.name(), file.line_column(span.start).line))
}

fn pass_report(plan: &Plan, sources: &Sources, handle: PassHandle) -> PassReport {
    let pass = plan.pipeline.pass(handle);
    let planned = plan.pass(handle);
    let names = |wanted: fn(umbragraph_pipeline::pipeline::Usage) -> bool| -> Vec<String> {
        let names: BTreeSet<&String> = pass
            .accesses()
            .iter()
            .filter(|one| wanted(one.usage))
            .map(|one| &plan.pipeline.resource(one.resource).name)
            .collect();
        names.into_iter().cloned().collect()
    };
    let attachments = planned.map_or_else(Vec::new, |planned| {
        let color = planned.color.iter().map(|one| ("color", one));
        color
            .chain(planned.depth.iter().map(|one| ("depth", one)))
            .chain(planned.stencil.iter().map(|one| ("stencil", one)))
            .map(|(kind, one)| AttachmentReport {
                resource: one.resource.clone(),
                kind: kind.to_owned(),
                load: match one.load {
                    LoadOperation::Load => "load".to_owned(),
                    LoadOperation::Clear(()) => "clear".to_owned(),
                    LoadOperation::Discard => "discard".to_owned(),
                },
                store: if one.store == StoreOperation::Store { "store" } else { "discard" }.to_owned(),
                transient_attachment: one.transient_attachment,
            })
            .collect()
    });
    PassReport {
        name: pass.name.clone(),
        kind: pass.kind.clone(),
        work: match pass.work() {
            Work::Nothing => "nothing",
            Work::Cpu(_) => "cpu",
            Work::Render(_) => "draw",
            Work::Compute(_) => "compute",
            Work::Transfer(_) => "copy",
        }
        .to_owned(),
        live: planned.is_some(),
        group: planned.map(|planned| planned.group),
        toggle: pass.condition.map(|condition| plan.pipeline.condition_name(condition)),
        passthrough: planned.map_or_else(Vec::new, |planned| {
            planned
                .passthrough
                .iter()
                .map(|(name, fallback)| format!("{fallback} in place of {name}"))
                .collect()
        }),
        why: match planned {
            Some(_) => shortened(why_kept(plan, handle)),
            None => shortened(why_culled(plan, &pass.name)),
        },
        reads: names(umbragraph_pipeline::pipeline::Usage::reads),
        writes: names(umbragraph_pipeline::pipeline::Usage::writes),
        attachments,
        settings: planned.map_or_else(BTreeMap::new, |planned| settings(plan, planned)),
        workgroups: planned.and_then(|planned| planned.workgroups),
        variants: planned.map_or_else(Vec::new, |planned| planned.variants.clone()),
        declared: place_of(sources, pass.place),
    }
}

/// Returns at most [`MAX_STEPS`] steps of a reason, followed by a note if there are more.
fn shortened(way: impl Iterator<Item = String>) -> Vec<String> {
    let mut way: Vec<String> = way.take(MAX_STEPS + 1).collect();
    if way.len() > MAX_STEPS {
        way.truncate(MAX_STEPS);
        way.push("and so on: `umbragraph why` tells every step".to_owned());
    }
    way
}

fn resources(plan: &Plan, sources: &Sources, columns: &[PassHandle]) -> Vec<ResourceReport> {
    let mut used: Vec<(Vec<usize>, Vec<usize>)> = vec![Default::default(); plan.pipeline.resources.len()];
    for (column, pass) in columns.iter().enumerate() {
        for one in plan.pipeline.pass(*pass).accesses() {
            let (reads, writes) = &mut used[one.resource.index()];
            if one.usage.reads() && reads.last() != Some(&column) {
                reads.push(column);
            }
            if one.usage.writes() && writes.last() != Some(&column) {
                writes.push(column);
            }
        }
    }
    let mut aliases: BTreeMap<Physical, Vec<&String>> = BTreeMap::new();
    for (name, planned) in &plan.resources {
        aliases.entry(planned.physical).or_default().push(name);
    }
    let mut list = Vec::new();
    for handle in plan.pipeline.resource_handles() {
        let resource = plan.pipeline.resource(handle);
        let (read_in, written_in) = std::mem::take(&mut used[handle.index()]);
        let planned = plan.resource(handle);
        let live = |column: &usize| planned.is_none() || plan.position(columns[*column]).is_some();
        let all: Vec<usize> =
            read_in.iter().chain(&written_in).copied().filter(|column| live(column)).collect();
        let (Some(first), Some(last)) = (all.iter().min(), all.iter().max()) else { continue };
        let place = match planned.map(|planned| planned.physical) {
            Some(Physical::Texture(index)) => format!("texture {index}"),
            Some(Physical::Buffer(index)) => format!("buffer {index}"),
            Some(Physical::Imported) => "imported".to_owned(),
            Some(Physical::Blackboard) => "blackboard".to_owned(),
            None => "nowhere".to_owned(),
        };
        let shared =
            planned.filter(|planned| matches!(planned.physical, Physical::Texture(_) | Physical::Buffer(_)));
        let others = shared.and_then(|planned| aliases.get(&planned.physical));
        list.push(ResourceReport {
            name: resource.name.clone(),
            kind: match resource.kind {
                ResourceKind::Texture(_) => "texture",
                ResourceKind::Buffer(_) => "buffer",
                _ => "data",
            }
            .to_owned(),
            lifetime: resource.lifetime(),
            live: planned.is_some(),
            description: planned
                .map_or_else(String::new, |planned| describe(planned.format, planned.size, planned.bytes)),
            bytes: planned.map_or(0, |planned| planned.bytes),
            place,
            shares_with: others
                .into_iter()
                .flatten()
                .filter(|name| ***name != resource.name)
                .map(|name| (*name).clone())
                .collect(),
            columns: [*first, *last],
            read_in,
            written_in,
            frames: resource.history.map(|history| history.frames),
            declared: place_of(sources, resource.place),
        });
    }
    list
}

fn describe(
    format: Option<wgpu_types::TextureFormat>,
    size: Option<umbragraph_compiler::TextureSize>,
    bytes: u64,
) -> String {
    let (Some(format), Some(size)) = (format, size) else {
        return if bytes > 0 { bytes_in_words(bytes) } else { String::new() };
    };
    let mut words = format!("{} {}×{}", format_name(format), size.width, size.height);
    for (count, what) in [(size.layers, "layers"), (size.mips, "mips"), (size.samples, "samples")] {
        if count > 1 {
            words.push_str(&format!(" · {count} {what}"));
        }
    }
    words
}

/// Formats a number of bytes with a binary unit, such as "1.5 MiB".
pub fn bytes_in_words(bytes: u64) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut unit = 0;
    let mut value = bytes as f64;
    while value >= 1024.0 && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{bytes} B") } else { format!("{value:.1} {}", units[unit]) }
}

fn alive(resources: &[ResourceReport], columns: usize) -> Vec<u64> {
    let mut alive = vec![0u64; columns];
    for resource in resources.iter().filter(|one| one.live && one.place.contains(' ')) {
        let lasting = resource.lifetime != Lifetime::Transient;
        let [first, last] = if lasting { [0, columns.saturating_sub(1)] } else { resource.columns };
        for sum in &mut alive[first..=last] {
            *sum += resource.bytes;
        }
    }
    alive
}

fn classes(plan: &Plan) -> Vec<CompatibilityClassReport> {
    /// A compatibility class during counting: its physical resources with their bytes, and the total bytes of its
    /// resources.
    #[derive(Default)]
    struct CompatibilityClass {
        places: BTreeMap<Physical, u64>,
        members: Vec<u64>,
    }
    // By what they are, for buffers their size class, and how they are used.
    let mut classes: BTreeMap<(String, u64, String), CompatibilityClass> = BTreeMap::new();
    for planned in plan.resources.values() {
        let shares = planned.lifetime == Lifetime::Transient && !planned.conditional;
        let place = match planned.physical {
            Physical::Texture(index) => {
                plan.textures.get(index).map(|one| (in_words(one.usages.iter_names()), one.bytes))
            }
            Physical::Buffer(index) => {
                plan.buffers.get(index).map(|one| (in_words(one.usages.iter_names()), one.bytes))
            }
            _ => None,
        };
        let Some((usages, bytes)) = place else { continue };
        let size = match planned.size {
            Some(_) => 0,
            None => planned.bytes.checked_next_power_of_two().filter(|_| shares).unwrap_or(planned.bytes),
        };
        let kept = match planned.lifetime {
            Lifetime::Transient if planned.conditional => ", left unwritten by a toggle",
            Lifetime::Transient => "",
            _ => ", kept from frame to frame",
        };
        let what = describe(planned.format, planned.size, 0);
        let class = classes.entry((what, size, format!("({usages}{kept})"))).or_default();
        class.places.insert(planned.physical, bytes);
        class.members.push(planned.bytes);
    }
    let report = |((what, _, usages), class): ((String, u64, String), CompatibilityClass)| {
        let size = |of: Option<&u64>| bytes_in_words(of.copied().unwrap_or(0));
        let (min, max) = (size(class.members.iter().min()), size(class.members.iter().max()));
        let what = match what.is_empty() {
            false => what,
            true if min == max => min,
            true => format!("{min} to {max}"),
        };
        CompatibilityClassReport {
            description: format!("{what} {usages}"),
            resources: class.members.len(),
            created: class.places.len(),
            bytes: class.places.values().sum(),
        }
    };
    classes.into_iter().map(report).collect()
}

/// Joins the names of the flags that are set.
fn in_words<F>(flags: impl Iterator<Item = (&'static str, F)>) -> String {
    let names: Vec<&str> = flags.map(|(name, _)| name).collect();
    names.join(", ").to_lowercase().replace('_', " ")
}

fn edges(plan: &Plan, graph: &Graph, column_of: &[usize]) -> Vec<EdgeReport> {
    let report = |from: PassHandle, to: PassHandle, kind, resource: Option<ResourceHandle>| EdgeReport {
        from: column_of[from.index()],
        to: column_of[to.index()],
        kind,
        resource: resource.map(|resource| plan.pipeline.resource(resource).name.clone()),
        version: None,
    };
    let mut edges = Vec::new();
    for edge in graph.graph.edge_references() {
        let GraphNode::Pass(to) = graph.graph[edge.target()] else { continue };
        edges.push(match (graph.graph[edge.source()], edge.weight()) {
            (GraphNode::Version { resource, range, number, writer }, Edge::Reads) => EdgeReport {
                version: Some(format!("{number}{}", describe_range(range))),
                ..report(writer, to, EdgeKind::Data, Some(resource))
            },
            (GraphNode::Pass(from), Edge::Order(hazard)) => match hazard {
                Hazard::WriteAfterRead(resource) => {
                    report(from, to, EdgeKind::WriteAfterRead, Some(*resource))
                }
                Hazard::WriteAfterWrite(resource) => {
                    report(from, to, EdgeKind::WriteAfterWrite, Some(*resource))
                }
                Hazard::Explicit => report(from, to, EdgeKind::Explicit, None),
            },
            _ => continue,
        });
    }
    let pipeline = &plan.pipeline;
    for reader in pipeline.pass_handles() {
        for one in pipeline.pass(reader).accesses() {
            let history = pipeline.resource(one.resource).history.filter(|history| history.back > 0);
            let writers = history.map(|history| surviving_writers(pipeline, graph, history.of));
            let later = |writer| report(writer, reader, EdgeKind::LaterFrame, Some(one.resource));
            edges.extend(writers.into_iter().flatten().map(later));
        }
    }
    edges.sort();
    edges.dedup();
    edges
}

fn describe_range(range: SubresourceRange) -> String {
    if range == SubresourceRange::WHOLE { String::new() } else { format!(", {range}") }
}
