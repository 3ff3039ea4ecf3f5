//! Units: declarations with all that they see of others, each of which is proven once.
//!
//! WGSL resolves names at module scope in any order, so a declaration is valid, or not, by its own text and by what it
//! sees of what it mentions: of a function its signature and its summary ([`crate::rules::summary`]), of anything else
//! all. Types and constants that mention one another in a circle are one unit; a text with such functions is proven by
//! itself. All that adds up over the functions that an entry point reaches, as limits and collisions of bindings do, is
//! worked out from them ([`super::modules`]); whether the stages of a module fit together is one more unit.
//!
//! A summary is known once some text with the function has been proven. Until then its callers are open.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use super::components::{Edges, components};
use super::content::{Content, Hash};
use super::interned::{Declarations, Id};
use super::kept::Kept;
use super::modules::Used;
use super::overrides;
use crate::axes::Axes;
use crate::reflection::{Binding, EntryPoint, Reflection};
use crate::rules::summary::Summary;
use crate::written::declarations::Kind;
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};

use crate::written::rejection::Excess;

/// A bit set of target profiles.
pub(super) type Profiles = u64;

/// The bit of the profile with this index. All profiles from index 63 on share the last bit.
pub(super) fn bit(profile: usize) -> Profiles {
    1 << profile.min(Profiles::BITS as usize - 1)
}

/// An error or warning about a validation unit or a module.
#[derive(Clone, Debug)]
pub(super) struct Refusal {
    /// The diagnostic as reported for the first module with the finding.
    pub(super) diagnostic: Diagnostic,
    pub(super) profiles: Profiles,
    pub(super) excess: Option<Excess>,
    pub(super) overrides: AxisValues,
    /// Whether the finding makes modules invalid: `true` for naga and WGSL rules, `false` for advice and external
    /// validators.
    pub(super) is_fatal: bool,
}

#[derive(Debug, Default)]
pub(super) struct Unit {
    /// The hash of everything that the validation unit consists of; the same in every run.
    pub(super) hash: Hash,
    /// The profiles that have accepted a module with this unit.
    pub(super) accepted: Profiles,
    pub(super) refusals: Vec<Refusal>,
    /// The properties of a function that affect its callers; `None` until a module with the function is validated, and
    /// for other units.
    pub(super) summary: Option<Arc<Summary>>,
    /// The profiles that have accepted a module in which an entry point reaches the unit.
    pub(super) reached: Profiles,
    /// The id of the part of the unit that its dependents rely on, such as a function's signature; `None` if not known
    /// yet.
    pub(super) interface: Option<Id>,
    /// The resources that a function uses; `None` until a module with the function is validated, and for other units.
    pub(super) used: Option<Used>,
    /// The binding of a resource variable, without visibility, which depends on entry points; `None` for other units.
    pub(super) binding: Option<Binding>,
    /// The reflection of an entry point, without the resources that it uses; `None` for other units.
    pub(super) entry_point: Option<EntryPoint>,
    /// For a unit that is a module's interface, the reflection of every module with this interface; otherwise `None`.
    pub(super) reflection: Option<Arc<Reflection>>,
    /// The name of the first declaration; `None` for a unit that is not made of declarations.
    pub(super) name: Option<Id>,
    /// Whether the result follows from other units, so that it is not stored between runs.
    pub(super) follows: bool,
}

impl Unit {
    pub(super) fn refused(&self) -> Profiles {
        self.refusals.iter().filter(|one| one.is_fatal).fold(0, |all, one| all | one.profiles)
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Key {
    /// Usually one declaration, or several that refer to one another, with the interfaces of all names that they
    /// mention.
    Declarations {
        directives: Id,
        members: Box<[Id]>,
        environment: Box<[(Id, Id)]>,
    },
    Directives(Box<[Id]>),
    /// The interface of a module: entry points and the units that they use, separated by `u32::MAX`.
    Interface(Box<[Id]>),
    /// The interfaces of a module's entry points, which must match between stages.
    Stages(Box<[Id]>),
}

/// The validation units of one module.
#[derive(Clone, Debug, Default)]
pub(super) struct Resolved {
    pub(super) units: Vec<Id>,
    /// The unit of each declaration, in the same order; `None` if not known yet.
    pub(super) of_declarations: Vec<Option<Id>>,
    /// The ids of the declarations that call a function not analysed yet.
    pub(super) open: Vec<Id>,
    /// The unit of the module's interface; `None` if not derived yet.
    pub(super) module: Option<Id>,
    /// Whether functions refer to one another in a cycle.
    pub(super) is_circular: bool,
}

/// The override axes of a template: from the id of the axis name to an id that identifies the values to validate.
pub(super) type Overrides = HashMap<Id, Id>;

/// The validation units of all modules: declarations with everything that they depend on, each validated once.
#[derive(Debug, Default)]
pub(super) struct Units {
    pub(super) all: Vec<Unit>,
    by_key: HashMap<Key, Id>,
    /// The hash of each interface (the part of a declaration that dependents rely on), indexed by interface id.
    interfaces: Vec<Hash>,
    by_interface: HashMap<Hash, Id>,
    /// For each name, the number of the module that last declared it and the declaration's index there.
    at: Vec<(u32, u32)>,
    texts: u32,
    /// The unit of the current module's directives.
    directives: Id,
    /// The distinct reflections of modules, so that equal ones share memory.
    pub(super) reflections: HashSet<Arc<Reflection>>,
    /// For each declaration, the interfaces it was last resolved with and the resulting unit.
    last: Vec<Option<(Vec<Option<Id>>, Id)>>,
    /// The units that earlier runs have validated; `None` if no store for results is used.
    pub(super) kept: Option<Kept>,
}

impl Units {
    /// Returns the validation units of a module. `summaries` holds the properties of the module's functions that affect
    /// callers; `None` if the module was not just validated.
    pub(super) fn resolve(
        &mut self,
        declarations: &Declarations,
        (text, overrides): (&[Id], &Overrides),
        summaries: Option<&BTreeMap<String, Summary>>,
    ) -> Resolved {
        let known = |id: &Id| &declarations.all[*id as usize];
        self.texts += 1;
        self.at.resize(declarations.names.len(), (0, 0));
        for (local, id) in text.iter().enumerate() {
            if let Some(name) = known(id).name {
                self.at[name as usize] = (self.texts, local as u32);
            }
        }
        let mut edges = Edges::default();
        for id in text {
            let mentions = known(id).mentions.iter();
            edges.node(mentions.filter_map(|name| self.local(*name)).map(|at| at as u32));
        }
        let mut directives: Vec<Id> =
            text.iter().copied().filter(|id| known(id).kind == Kind::Directive).collect();
        directives.sort_unstable();
        let directives = self.unit(Key::Directives(directives.into()), None, declarations);
        self.directives = directives;

        let mut resolved = Resolved { of_declarations: vec![None; text.len()], ..Resolved::default() };
        let mut interfaces: Vec<Option<Id>> = vec![None; text.len()];
        let mut seen: Vec<Option<Id>> = Vec::new();
        for component in components(&edges).iter() {
            let functions =
                component.iter().filter(|at| declarations.is_function(text[**at as usize])).count();
            resolved.is_circular |= functions > 0 && component.len() > 1;
            let is_inside = |at: usize| component.contains(&(at as u32));
            // What is seen, in the order of mentions.
            seen.clear();
            seen.push(Some(directives));
            let mut is_open = false;
            for at in component {
                let declared = known(&text[*at as usize]);
                let own = declared.name.filter(|_| declared.kind == Kind::Override);
                seen.extend(own.map(|name| overrides.get(&name).copied()));
                for name in &declared.mentions {
                    let other = self.local(*name).filter(|other| !is_inside(*other));
                    is_open |= other.is_some_and(|other| interfaces[other].is_none());
                    seen.push(other.and_then(|other| interfaces[other]));
                }
            }
            if is_open {
                resolved.open.extend(component.iter().map(|at| text[*at as usize]));
                continue;
            }
            let first = text[component[0] as usize];
            // Texts that follow one another mostly see the same.
            let last = self.last.get(first as usize).and_then(Option::as_ref);
            let unit = match last.filter(|(last, _)| component.len() == 1 && *last == seen) {
                Some((_, unit)) => *unit,
                None => {
                    let mut environment: Vec<(Id, Id)> = Vec::new();
                    let mut seen_by_name = seen.iter().skip(1);
                    for at in component {
                        let declared = known(&text[*at as usize]);
                        let own = declared.name.filter(|_| declared.kind == Kind::Override);
                        let names = own.iter().chain(&declared.mentions);
                        let named = names.zip(seen_by_name.by_ref());
                        environment.extend(named.filter_map(|(name, seen)| Some((*name, (*seen)?))));
                    }
                    environment.sort_unstable();
                    environment.dedup();
                    let mut members: Vec<Id> = component.iter().map(|at| text[*at as usize]).collect();
                    members.sort_unstable();
                    let (members, environment) = (members.into(), environment.into());
                    let key = Key::Declarations { directives, members, environment };
                    let unit = self.unit(key, known(&first).name, declarations);
                    if self.last.len() <= first as usize {
                        self.last.resize(declarations.all.len(), None);
                    }
                    self.last[first as usize] = Some((seen.clone(), unit));
                    unit
                }
            };
            resolved.units.push(unit);
            for at in component {
                resolved.of_declarations[*at as usize] = Some(unit);
            }
            let found = &self.all[unit as usize];
            let is_function = declarations.is_function(first);
            if found.interface.is_none() || is_function && found.used.is_none() {
                self.see(unit, component, (declarations, text), &interfaces, summaries);
            }
            component.iter().for_each(|at| interfaces[*at as usize] = self.all[unit as usize].interface);
        }
        if resolved.open.is_empty() {
            let entries = text.iter().zip(&resolved.of_declarations);
            let entries = entries.filter(|(id, _)| known(id).kind == Kind::EntryPoint);
            let interface = |unit: &Option<Id>| self.all[(*unit)? as usize].interface;
            let mut stages: Vec<Id> = entries.filter_map(|(_, unit)| interface(unit)).collect();
            stages.sort_unstable();
            resolved.units.push(self.unit(Key::Stages(stages.into()), None, declarations));
        }
        resolved
    }

    /// Computes the interface of a unit, the part that dependents rely on. For a function, it consists of the header,
    /// the interfaces of names in the header, and the summary. For other declarations it is everything.
    fn see(
        &mut self,
        unit: Id,
        component: &[u32],
        (declarations, text): (&Declarations, &[Id]),
        interfaces: &[Option<Id>],
        summaries: Option<&BTreeMap<String, Summary>>,
    ) {
        let hash = match component {
            [at] if declarations.is_function(text[*at as usize]) => {
                let declared = &declarations.all[text[*at as usize] as usize];
                let name = declared.name.map(|name| declarations.name(name));
                let found =
                    || name.and_then(|name| summaries?.get(name)).map(|found| Arc::new(found.clone()));
                let known = &mut self.all[unit as usize];
                known.summary = known.summary.take().or_else(found);
                let summary = known.summary.clone();
                known.used = summary.as_ref().map(|summary| Used::new(summary, declarations));
                // Nobody calls an entry point; others see where it stands in the pipeline.
                let of_entry = Arc::<Summary>::default();
                let Some(summary) =
                    summary.or_else(|| (declared.kind == Kind::EntryPoint).then_some(of_entry))
                else {
                    return;
                };
                let local = |name: Id| self.local(name);
                let mut parts: Vec<(&str, Hash)> = Vec::new();
                for name in &declared.visible {
                    let interface = local(*name).and_then(|at| interfaces[at]);
                    let hash = interface.map(|interface| self.interfaces[interface as usize]);
                    parts.extend(hash.map(|hash| (declarations.name(*name), hash)));
                }
                let mut hash = Content::new("function");
                hash.add(declared.text[..declared.header].as_bytes()).add(summary.text.as_bytes());
                hash.add(&self.all[self.directives as usize].hash).all(parts);
                hash.finish()
            }
            _ => self.all[unit as usize].hash,
        };
        self.all[unit as usize].interface = Some(self.interface_of(hash));
    }

    fn interface_of(&mut self, hash: Hash) -> Id {
        let next = self.interfaces.len() as Id;
        let id = *self.by_interface.entry(hash).or_insert(next);
        self.interfaces.extend((id == next).then_some(hash));
        id
    }

    /// Returns the override axes of a template, each with an id that identifies the values to validate.
    pub(super) fn overrides(&mut self, declarations: &Declarations, axes: &Axes) -> Overrides {
        let all = overrides::by_name(axes).into_iter();
        let interface = |(name, values): (&str, String)| {
            let hash = Content::new("override").add(values.as_bytes()).finish();
            Some((declarations.named(name)?, self.interface_of(hash)))
        };
        all.filter_map(interface).collect()
    }

    pub(super) fn unit(&mut self, key: Key, name: Option<Id>, declarations: &Declarations) -> Id {
        if let Some(id) = self.by_key.get(&key) {
            return *id;
        }
        let text = |id: &Id| ("", *blake3::hash(declarations.all[*id as usize].text.as_bytes()).as_bytes());
        let hash = match &key {
            Key::Declarations { directives, members, environment } => {
                let mut hash = Content::new("declarations");
                hash.add(&self.all[*directives as usize].hash).all(members.iter().map(text));
                let seen = |(name, interface): &(Id, Id)| {
                    (declarations.name(*name), self.interfaces[*interface as usize])
                };
                hash.all(environment.iter().map(seen));
                hash.finish()
            }
            Key::Directives(all) => Content::new("directives").all(all.iter().map(text)).finish(),
            Key::Stages(entries) => {
                let hashes = entries.iter().map(|interface| ("", self.interfaces[*interface as usize]));
                Content::new("stages").all(hashes).finish()
            }
            Key::Interface(parts) => {
                let mut hash = Content::new("interface");
                for part in parts {
                    let bytes = self.all.get(*part as usize).map(|unit| unit.hash);
                    hash.add(bytes.as_ref().map_or(&[], |hash| &hash[..]));
                }
                hash.finish()
            }
        };
        let id = self.all.len() as Id;
        let known = self.kept.as_ref().and_then(|kept| kept.unit(&hash)).unwrap_or_default();
        self.all.push(Unit { hash, name, ..known });
        self.by_key.insert(key, id);
        id
    }

    /// The index of the current module's declaration with this name, or `None`.
    pub(super) fn local(&self, name: Id) -> Option<usize> {
        let (text, at) = self.at[name as usize];
        (text == self.texts).then_some(at as usize)
    }

    /// The index of the declaration in a module that has the unit's name, or `None`.
    pub(super) fn position(&self, declarations: &Declarations, text: &[Id], unit: Id) -> Option<usize> {
        let name = self.all.get(unit as usize)?.name?;
        text.iter().position(|id| declarations.all[*id as usize].name == Some(name))
    }
}
