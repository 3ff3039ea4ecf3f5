//! Passthroughs: what readers see in frames without the passes that write a resource.

use std::collections::{BTreeMap, BTreeSet};

use crate::access::version::Version;
use crate::pipeline::located::Located as _;
use crate::pipeline::names::{Instance, expression_diagnostic, is_of, reference_in};
use crate::pipeline::pass::{Access, Pass};
use crate::pipeline::resource::ResourceKind;
use crate::pipeline::resources::history;
use crate::pipeline::state::shared::Shared;
use crate::pipeline::toggle::{Passthrough, Toggle};
use crate::work::ResourceHandle;
use umbragraph_text::diagnostic::{Code, Diagnostic, codes, list_of};
use umbragraph_text::document::{Entry, Kind, Value, pointer_join};
use umbragraph_text::source::Span;

/// Returns the fallback of each resource, from the "passthrough" keys of passes and uses of subgraphs. Adds accesses of
/// the fallbacks to the passes that read these resources. Resources with an invalid passthrough are added to
/// `uncertain`.
pub(super) fn connect(
    declarations: &[Instance<'_>],
    passes: &mut [Pass],
    toggles: &[Toggle],
    uncertain: &mut BTreeSet<ResourceHandle>,
    shared: &mut Shared,
) -> BTreeMap<ResourceHandle, Passthrough> {
    let mut passthroughs: BTreeMap<ResourceHandle, Passthrough> = BTreeMap::new();
    for declaration in declarations {
        for one in declaration.entry.value.entries_of("passthrough") {
            let check = PassthroughCheck { declaration, one, passes, toggles, uncertain, shared };
            match check.passthrough(&passthroughs) {
                Ok(None) => {}
                Ok(Some((resource, passthrough))) => {
                    passthroughs.entry(resource).or_insert(passthrough);
                }
                Err(diagnostic) => {
                    // What would be said of the readers of what is meant only follows.
                    let suggested = check.affected();
                    let diagnostic = diagnostic.map(|diagnostic| *diagnostic);
                    shared.report_from(diagnostic, &declaration.environment);
                    uncertain.extend(suggested);
                }
            }
        }
    }
    let cycles: Vec<ResourceHandle> =
        passthroughs.keys().copied().filter(|resource| leads_back(&passthroughs, *resource)).collect();
    if let Some(first) = cycles.first() {
        let passthrough = &passthroughs[first];
        let names = list_of(cycles.iter().map(|one| shared.resources[one.index()].name.as_str()));
        let message = format!("{names} are fallbacks of one another in a cycle");
        let diagnostic = passthrough.error(codes::PASSTHROUGH, message);
        shared.diagnostics.push(diagnostic.help("remove the passthrough of one of them"));
        uncertain.extend(&cycles);
        passthroughs.retain(|resource, _| !cycles.contains(resource));
    }
    for pass in passes.iter_mut() {
        for (one, original) in add_fallbacks(pass, &passthroughs) {
            let name = &shared.resources[original.index()].name;
            let message = format!("\"{}\" attaches \"{name}\", which has a passthrough", pass.name);
            let help = "only resources that are bound or copied from can have a passthrough; give the pass the same toggle";
            let mut diagnostic = one.error(codes::PASSTHROUGH, message).help(help);
            if let Some(passthrough) = passthroughs.get(&original) {
                diagnostic = diagnostic.related(passthrough.place, "the passthrough");
            }
            shared.diagnostics.push(diagnostic);
        }
    }
    passthroughs
}

fn leads_back(passthroughs: &BTreeMap<ResourceHandle, Passthrough>, start: ResourceHandle) -> bool {
    let next = |at: &ResourceHandle| passthroughs.get(at).map(|passthrough| passthrough.fallback);
    std::iter::successors(next(&start), next).take(passthroughs.len()).any(|at| at == start)
}

/// Adds an access of the fallback for each read of a resource with a passthrough. Attachments cannot have a fallback:
/// these accesses are returned, each with the resource that has the passthrough.
pub fn add_fallbacks(
    pass: &mut Pass,
    passthroughs: &BTreeMap<ResourceHandle, Passthrough>,
) -> Vec<(Access, ResourceHandle)> {
    let (mut added, mut rejected): (Vec<Access>, Vec<(Access, ResourceHandle)>) = (Vec::new(), Vec::new());
    if passthroughs.is_empty() {
        return rejected;
    }
    for one in pass.accesses.iter_mut().filter(|one| !one.usage.writes()) {
        let mut otherwise = Vec::new();
        let mut accesses: Vec<Access> = Vec::new();
        let mut at = one.resource;
        while let Some(passthrough) =
            passthroughs.get(&at).filter(|passthrough| pass.condition != Some(passthrough.condition))
        {
            if one.usage.is_attachment() {
                rejected.push((one.clone(), at));
                break;
            }
            match accesses.last_mut() {
                None => one.when = vec![passthrough.condition],
                Some(last) => last.when.push(passthrough.condition),
            }
            otherwise.push(passthrough.condition.opposite());
            accesses.push(Access {
                resource: passthrough.fallback,
                range: one.range,
                usage: one.usage,
                version: passthrough.version.clone(),
                when: otherwise.clone(),
                place: passthrough.place,
                pointer: passthrough.pointer.clone(),
            });
            at = passthrough.fallback;
        }
        added.extend(accesses);
    }
    for one in added {
        // What the pass reads anyway it reads in these frames too.
        let anyway = pass.accesses().iter().any(|known| {
            known.when.is_empty()
                && (known.resource, known.range, known.usage, &known.version)
                    == (one.resource, one.range, one.usage, &one.version)
        });
        if !anyway && !pass.accesses().contains(&one) {
            pass.accesses.push(one);
        }
    }
    rejected
}

/// The reason to reject an entry of a "passthrough"; `None` if it only follows from another diagnostic.
type Rejection = Option<Box<Diagnostic>>;

/// One entry of a "passthrough", with the context for checking it.
struct PassthroughCheck<'a> {
    declaration: &'a Instance<'a>,
    one: &'a Entry,
    passes: &'a [Pass],
    toggles: &'a [Toggle],
    uncertain: &'a BTreeSet<ResourceHandle>,
    shared: &'a Shared,
}

impl PassthroughCheck<'_> {
    fn reject(&self, place: Span, message: String, help: impl Into<String>) -> Rejection {
        Some(Box::new(self.diagnostic(codes::PASSTHROUGH, place, message, help)))
    }

    fn diagnostic(&self, code: Code, place: Span, message: String, help: impl Into<String>) -> Diagnostic {
        Diagnostic::error(code, place, message).pointer(self.pointer()).help(help)
    }

    fn pointer(&self) -> String {
        pointer_join(&format!("{}/passthrough", self.declaration.pointer), &self.one.key)
    }

    /// The resources that an invalid entry may concern: the named resource if the passes write it, else all resources
    /// that they write.
    fn affected(&self) -> BTreeSet<ResourceHandle> {
        let environment = &self.declaration.environment;
        let named = self.shared.find(&environment.resource(&self.one.key));
        let accesses = self.members().flat_map(Pass::accesses);
        let written: BTreeSet<ResourceHandle> =
            accesses.filter(|one| one.usage.writes()).map(|one| one.resource).collect();
        match named.filter(|named| written.contains(named)) {
            Some(named) => BTreeSet::from([named]),
            None => written.into_iter().chain(named).collect(),
        }
    }

    fn members(&self) -> impl Iterator<Item = &Pass> {
        self.passes.iter().filter(|pass| is_of(&pass.name, &self.declaration.name))
    }

    /// Resolves a reference to a resource and the version that it names; `None` if the resource is broken.
    fn resource(&self, text: &str, place: Span) -> Result<Option<(ResourceHandle, Version)>, Rejection> {
        let environment = &self.declaration.environment;
        let outside = environment.refer(text, &self.shared.scope).map_err(|mut error| {
            environment.widen(&mut error, std::iter::empty());
            let value = Value { span: place, kind: Kind::Text(text.to_owned()) };
            expression_diagnostic(&error, &value, &self.pointer()).map(Box::new)
        })?;
        let Some(handle) = self.shared.find(&outside.resource) else {
            let name = environment.resource_inside(&outside.resource).unwrap_or(&outside.resource);
            let resources = self.shared.resources.iter();
            let names = resources.filter_map(|resource| environment.resource_inside(&resource.name));
            let message = format!("there is no resource \"{name}\"");
            let diagnostic = self.diagnostic(codes::UNKNOWN_RESOURCE, place, message, "");
            let written = reference_in(text, name).and_then(|range| place.of_quoted(text, range));
            let diagnostic =
                diagnostic.suggest(name, names, written, |_| "declare it under \"resources\"".to_owned());
            return Err(Some(Box::new(diagnostic)));
        };
        if outside.back > 0 {
            let earlier = history::earlier(self.shared, handle, outside.back).ok_or_else(|| {
                let (message, help) = history::beyond(self.shared, handle, outside.back);
                let declared = self.shared.resources[handle.index()].place;
                let diagnostic = self.diagnostic(codes::HISTORY_READ, place, message, help);
                Some(Box::new(diagnostic.related(declared, "declared here")))
            })?;
            return Ok(Some((earlier, Version::Newest)));
        }
        let known = !matches!(self.shared.resources[handle.index()].kind, ResourceKind::Broken);
        Ok(known.then(|| (handle, outside.version.into())))
    }

    /// Returns the resource of the entry and its passthrough. `None` if the entry has no effect, or cannot be checked
    /// because of other errors.
    fn passthrough(
        &self,
        others: &BTreeMap<ResourceHandle, Passthrough>,
    ) -> Result<Option<(ResourceHandle, Passthrough)>, Rejection> {
        let key = self.one.key_span;
        let has_toggle = self.declaration.entry.value.get("toggle").is_some()
            || !self.declaration.environment.toggles.is_empty();
        if !has_toggle {
            let message = format!("\"{}\" has a passthrough, but no toggle", self.declaration.name);
            let help = "add \"toggle\", or remove the passthrough";
            return Err(self.reject(key, message, help));
        }
        let Some(written) = self.one.value.text() else { return Ok(None) };
        let Some((resource, _)) = self.resource(&format!("&{}", self.one.key), key)? else { return Ok(None) };
        let Some((fallback, version)) = self.resource(written, self.one.value.span)? else { return Ok(None) };
        let known = &self.shared.resources[resource.index()];
        let other = &self.shared.resources[fallback.index()];
        let mut members = self.members().peekable();
        // A pass that could not be declared, or is switched off, says nothing about what it writes.
        if members.peek().is_none() {
            return Ok(None);
        }
        let Some(writer) = members.find(|pass| pass.writes(resource)) else {
            if self.uncertain.contains(&resource) {
                return Ok(None);
            }
            let message = format!("\"{}\" does not write \"{}\"", self.declaration.name, known.name);
            let accesses = self.members().flat_map(Pass::accesses).filter(|one| one.usage.writes());
            let names = accesses.map(|one| self.shared.resources[one.resource.index()].name.as_str());
            let written: BTreeSet<&str> = names.collect();
            let written = if written.is_empty() { "nothing".to_owned() } else { list_of(written) };
            let help =
                format!("a passthrough names what the pass writes ({written}), and what readers see instead");
            return Err(self.reject(key, message, &help));
        };
        // An unknown toggle has a diagnostic already.
        let Some(condition) = writer.condition else { return Ok(None) };
        let toggle = &self.toggles[condition.toggle].name;
        if fallback == resource {
            let message = format!("\"{}\" cannot be its own fallback", known.name);
            let help = "name what readers see instead";
            return Err(self.reject(self.one.value.span, message, help));
        }
        let mut elsewhere = self.passes.iter().filter(|pass| pass.condition != Some(condition));
        if let Some(pass) = elsewhere.find(|pass| pass.writes(resource)) {
            let loads = pass.writes_of(resource).any(|one| one.usage.reads());
            let verb = if loads { "loads and writes" } else { "writes" };
            let message =
                format!("\"{}\" {verb} \"{}\" too, without the toggle \"{toggle}\"", pass.name, known.name);
            let place = pass.writes_of(resource).next().map_or(pass.place, |one| one.place);
            let help = "a resource with a passthrough is written only by passes of one toggle: give the other the same, or write to another resource";
            let diagnostic = self.diagnostic(codes::PASSTHROUGH, key, message, help);
            return Err(Some(Box::new(diagnostic.related(place, "it is written here"))));
        }
        if let Some(twin) = others.get(&resource) {
            if (twin.fallback, &twin.version) != (fallback, &version) {
                let message = format!("\"{}\" has two passthroughs", known.name);
                let diagnostic =
                    self.diagnostic(codes::PASSTHROUGH, key, message, "one resource has one passthrough");
                return Err(Some(Box::new(diagnostic.related(twin.place, "the other"))));
            }
            return Ok(None);
        }
        let error = match (&known.kind, &other.kind) {
            (ResourceKind::Texture(_), ResourceKind::Texture(_))
            | (ResourceKind::Buffer(_), ResourceKind::Buffer(_)) => None,
            (ResourceKind::Data(Some(a)), ResourceKind::Data(Some(b))) => (a != b)
                .then(|| format!("\"{}\" and \"{}\" publish other values or views", known.name, other.name)),
            (ResourceKind::Data(None), _) | (_, ResourceKind::Data(None)) => return Ok(None),
            _ => {
                let (own, wanted) = (known.kind_name(), other.kind_name());
                Some(format!("\"{}\" is {own}, \"{}\" is {wanted}", known.name, other.name))
            }
        };
        if let Some(message) = error {
            let help = "the fallback is of the same kind; blackboard data has the same shape";
            return Err(self.reject(self.one.value.span, message, help));
        }
        let (place, pointer) = (self.one.value.span, self.pointer());
        Ok(Some((resource, Passthrough { condition, fallback, version, place, pointer })))
    }
}
