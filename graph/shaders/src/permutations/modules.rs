//! Interfaces of modules, worked out from those of their declarations.
//!
//! All that naga, limits and the reflection ask of an entry point beyond its own declaration adds up over the functions
//! that it reaches: the variables that they use, and textures with their samplers. Each function says what it uses
//! itself ([`crate::rules::uses`]); here it is followed through the calls of one text. Variants that agree in what is
//! found are one interface. It is valid without a proof of its own if its bindings are no more than every profile
//! guarantees and no two stand at one place: all else was seen where each part was proven, reached by an entry point.
//!
//! Limits: modules in which pointers to variables of the module are passed, and those with workgroup variables or
//! numbered overrides, are proven one by one; so are all of a family in which naga has seen something else than what is
//! found here.

use std::collections::BTreeMap;
use std::sync::Arc;

use wgpu_types::{BindingType, ShaderStages, TextureSampleType};

use super::interned::{Declarations, Id};
use super::prove::Subject;
use super::units::{Key, Profiles, Resolved, Units, bit};
use crate::reflection::{Binding, EntryPoint, Reflection};
use crate::rules::cost::Spent;
use crate::rules::limits;
use crate::rules::summary::Summary;
use crate::written::declarations::Kind;

/// The origin of a texture or sampler: the id of a module-scope variable, or an argument's index with the bit
/// [`ARGUMENT`] set.
type Root = u32;
const ARGUMENT: Root = 1 << 31;
const UNKNOWN: Root = Root::MAX;

/// The resources, texture-sampler pairs, calls and costs of one function, without those of the functions that it calls.
#[derive(Debug, Default)]
pub(super) struct Used {
    globals: Vec<Id>,
    sampled: Vec<(Root, Root)>,
    calls: Vec<(Id, Vec<Root>)>,
    spent: Spent<Id>,
}

impl Used {
    pub(super) fn new(summary: &Summary, declarations: &Declarations) -> Self {
        let Summary { uses, cost, .. } = summary;
        let root = |root: &String| match root.parse::<u32>() {
            Ok(argument) => ARGUMENT | argument,
            Err(_) => declarations.named(root).unwrap_or(UNKNOWN),
        };
        let calls = uses.calls.iter().filter_map(|(callee, given)| {
            Some((declarations.named(callee)?, given.iter().map(root).collect()))
        });
        Self {
            globals: uses.globals.iter().filter_map(|name| declarations.named(name)).collect(),
            sampled: uses.sampled.iter().map(|(image, sampler)| (root(image), root(sampler))).collect(),
            calls: calls.collect(),
            spent: cost.by(|name| declarations.named(name)),
        }
    }

    /// The operations of the function itself, without those of the functions that it calls.
    pub(super) fn spent(&self) -> &Spent<Id> {
        &self.spent
    }
}

/// The resources that an entry point uses, including those of all called functions.
#[derive(Debug, Default)]
struct Reached {
    entry: Id,
    /// The ids of the validation units of the variables that the entry point uses.
    variables: Vec<Id>,
    sampled: Vec<(Id, Id)>,
}

/// The interface of a module, derived from its declarations.
#[derive(Debug, Default)]
pub(super) struct Interface {
    /// The id of the validation unit that stands for the interface.
    pub(super) module: Id,
    /// The ids of the validation units of functions and variables that entry points reach.
    pub(super) reached: Vec<Id>,
    reflection: Arc<Reflection>,
}

impl Interface {
    /// Returns the bit set of wanted profiles whose limits the interface satisfies, and the reflection.
    pub(super) fn proven(&self, subject: &Subject<'_>) -> (Profiles, &Arc<Reflection>) {
        let fits = subject.wanted().filter(|(_, profile)| limits::fits(&self.reflection, profile));
        (fits.fold(0, |all, (at, _)| all | bit(at)), &self.reflection)
    }

    /// Returns `true` if the derived reflection equals `reflection`, which comes from naga.
    pub(super) fn is(&self, reflection: &Reflection) -> bool {
        *self.reflection == *reflection
    }
}

impl Units {
    /// Derives the interface of the module last passed to `resolve`, if all its declarations are known; otherwise
    /// `None`.
    pub(super) fn interface(
        &mut self,
        declarations: &Declarations,
        text: &[Id],
        resolved: &Resolved,
    ) -> Option<Interface> {
        let of_kind = |wanted: Kind| {
            let all = text.iter().zip(&resolved.of_declarations);
            let of = move |(id, unit): (&Id, &Option<Id>)| {
                unit.filter(|_| declarations.kind(*id) == wanted).map(|unit| (*id, unit))
            };
            all.filter_map(of)
        };
        let mut entries: Vec<(Id, Id)> = of_kind(Kind::EntryPoint).collect();
        entries.sort_by_key(|(id, _)| declarations.name_of(*id));
        let mut reached_by_any = vec![false; text.len()];
        let mut all: Vec<Reached> = Vec::new();
        for (id, entry) in &entries {
            let at = self.local(declarations.name_id(*id)?)?;
            all.push(self.reach(declarations, resolved, at, *entry, &mut reached_by_any)?);
        }
        let mut variables: Vec<(Id, Id)> = of_kind(Kind::Variable).collect();
        variables.sort_by_key(|(id, _)| declarations.name_of(*id));
        let mut overrides: Vec<(Id, Id)> = of_kind(Kind::Override).collect();
        overrides.sort_by_key(|(id, _)| declarations.name_of(*id));

        // Apart by what no unit can be.
        let mut parts = Vec::new();
        for each in &all {
            parts.extend([each.entry, UNKNOWN]);
            parts.extend(&each.variables);
            parts.push(UNKNOWN);
            parts.extend(each.sampled.iter().flat_map(|(image, sampler)| [image, sampler]));
            parts.push(UNKNOWN);
        }
        parts.extend(variables.iter().chain(&overrides).map(|(_, unit)| unit));
        let module = self.unit(Key::Interface(parts.into()), None, declarations);
        self.all[module as usize].follows = true;
        let reached = reached_by_any.iter().zip(&resolved.of_declarations);
        let reached = reached.filter_map(|(is_reached, unit)| unit.filter(|_| *is_reached)).collect();
        let reflection = match &self.all[module as usize].reflection {
            Some(known) => known.clone(),
            None => {
                let found = self.reflection(&all, &variables, &overrides, declarations)?;
                self.one_of_equal(found)
            }
        };
        Some(Interface { module, reached, reflection })
    }

    /// Returns the stored reflection that equals this one; stores this one if there is none.
    fn one_of_equal(&mut self, reflection: Reflection) -> Arc<Reflection> {
        if let Some(known) = self.reflections.get(&reflection) {
            return known.clone();
        }
        let new = Arc::new(reflection);
        self.reflections.insert(new.clone());
        new
    }

    /// Collects the resources that an entry point reaches through calls; `None` if a function's uses are not known.
    fn reach(
        &self,
        declarations: &Declarations,
        resolved: &Resolved,
        entry_at: usize,
        entry: Id,
        reached: &mut [bool],
    ) -> Option<Reached> {
        let mut seen = vec![false; reached.len()];
        let mut open = vec![entry_at];
        let mut used = Vec::new();
        let mut samples = false;
        while let Some(at) = open.pop() {
            if std::mem::replace(&mut seen[at], true) {
                continue;
            }
            reached[at] = true;
            let uses = self.all[resolved.of_declarations[at]? as usize].used.as_ref()?;
            samples |= !uses.sampled.is_empty();
            used.extend(&uses.globals);
            for (callee, _) in &uses.calls {
                open.push(self.local(*callee)?);
            }
        }
        used.sort_unstable_by_key(|name| declarations.name(*name));
        used.dedup();
        let mut variables = Vec::with_capacity(used.len());
        for name in used {
            let at = self.local(name)?;
            reached[at] = true;
            variables.push(resolved.of_declarations[at]?);
        }
        let mut known = BTreeMap::new();
        let pairs = match samples {
            true => self.sampled(resolved, entry_at, &mut known)?,
            false => Vec::new(),
        };
        let unit_of = |root: Root| self.local(root).and_then(|at| resolved.of_declarations[at]);
        let known = |root: Root| root & ARGUMENT == 0;
        let pairs = pairs.into_iter().filter(|(image, sampler)| known(*image) && known(*sampler));
        let mut pairs: Vec<(Root, Root)> = pairs.collect();
        pairs.sort_unstable_by_key(|(image, sampler)| {
            (declarations.name(*image), declarations.name(*sampler))
        });
        let sampled =
            pairs.into_iter().filter_map(|(image, sampler)| Some((unit_of(image)?, unit_of(sampler)?)));
        Some(Reached { entry, variables, sampled: sampled.collect() })
    }

    /// Returns the pairs of texture and sampler that a function and its callees use together; `None` if a function is
    /// not analysed yet.
    fn sampled(
        &self,
        resolved: &Resolved,
        at: usize,
        known: &mut BTreeMap<usize, Vec<(Root, Root)>>,
    ) -> Option<Vec<(Root, Root)>> {
        if let Some(known) = known.get(&at) {
            return Some(known.clone());
        }
        let uses = self.all[resolved.of_declarations[at]? as usize].used.as_ref()?;
        let mut found = uses.sampled.clone();
        for (callee, given) in &uses.calls {
            let passed = |root: Root| match root {
                UNKNOWN => UNKNOWN,
                argument if argument & ARGUMENT != 0 => {
                    given.get((argument & !ARGUMENT) as usize).copied().unwrap_or(UNKNOWN)
                }
                variable => variable,
            };
            let inner = self.sampled(resolved, self.local(*callee)?, known)?;
            found.extend(inner.into_iter().map(|(image, sampler)| (passed(image), passed(sampler))));
        }
        found.sort_unstable();
        found.dedup();
        known.insert(at, found.clone());
        Some(found)
    }

    /// Builds the reflection of a module from the resources that its entry points reach.
    fn reflection(
        &self,
        all: &[Reached],
        variables: &[(Id, Id)],
        overrides: &[(Id, Id)],
        declarations: &Declarations,
    ) -> Option<Reflection> {
        let place = |unit: &Id| {
            let binding = self.all[*unit as usize].binding.as_ref()?;
            Some((binding.group, binding.binding))
        };
        let mut entry_points = Vec::new();
        for each in all {
            let mut entry_point = self.all[each.entry as usize].entry_point.clone()?;
            entry_point.bindings = each.variables.iter().filter_map(place).collect();
            entry_point.bindings.sort_unstable();
            let pairs = each.sampled.iter();
            entry_point.sampling_pairs =
                pairs.filter_map(|(image, sampler)| Some((place(image)?, place(sampler)?))).collect();
            entry_point.sampling_pairs.sort_unstable();
            entry_points.push(entry_point);
        }
        let binding = |(_, unit): &(Id, Id)| {
            let mut binding = self.all[*unit as usize].binding.clone()?;
            for (each, entry_point) in all.iter().zip(&entry_points) {
                if each.variables.contains(unit) {
                    binding.entry.visibility |= entry_point.stage.stages();
                }
                if each.sampled.iter().any(|(image, _)| image == unit)
                    && let BindingType::Texture {
                        sample_type: TextureSampleType::Float { filterable },
                        multisampled: false,
                        ..
                    } = &mut binding.entry.ty
                {
                    *filterable = true;
                }
            }
            Some(binding)
        };
        let mut bindings: Vec<Binding> = variables.iter().filter_map(binding).collect();
        bindings.sort_by(|a, b| (a.group, a.binding, &a.name).cmp(&(b.group, b.binding, &b.name)));
        let (bindings, unused) =
            bindings.into_iter().partition(|binding| !binding.entry.visibility.is_empty());
        entry_points.sort_by(|a, b| (&a.name, a.stage).cmp(&(&b.name, b.stage)));
        let mut overrides: Vec<String> =
            overrides.iter().map(|(id, _)| declarations.name_of(*id).to_owned()).collect();
        overrides.sort();
        Some(Reflection { bindings, unused, entry_points, overrides })
    }

    /// Stores the bindings and entry points of a reflection in the validation units of their declarations. Data that
    /// depends on the resources that entry points use, such as visibility, is left out.
    pub(super) fn reflected(
        &mut self,
        declarations: &Declarations,
        text: &[Id],
        resolved: &Resolved,
        reflection: &Reflection,
    ) {
        let bindings: BTreeMap<&str, &Binding> = reflection
            .bindings
            .iter()
            .chain(&reflection.unused)
            .map(|binding| (binding.name.as_str(), binding))
            .collect();
        for (id, unit) in text.iter().zip(&resolved.of_declarations) {
            let Some(unit) = unit else { continue };
            let (unit, name) = (&mut self.all[*unit as usize], declarations.name_of(*id));
            match declarations.kind(*id) {
                Kind::Variable if unit.binding.is_none() => {
                    unit.binding = bindings.get(name).map(|binding| alone((*binding).clone()));
                }
                Kind::EntryPoint if unit.entry_point.is_none() => {
                    let found = reflection.entry_points.iter().find(|each| each.name == name);
                    unit.entry_point = found.map(|each| EntryPoint {
                        bindings: Vec::new(),
                        sampling_pairs: Vec::new(),
                        ..each.clone()
                    });
                }
                _ => {}
            }
        }
    }
}

/// Returns the binding as if no entry point used it: no visibility, not filterable.
fn alone(mut binding: Binding) -> Binding {
    binding.entry.visibility = ShaderStages::NONE;
    if let BindingType::Texture { sample_type: TextureSampleType::Float { filterable }, .. } =
        &mut binding.entry.ty
    {
        *filterable = false;
    }
    binding
}
