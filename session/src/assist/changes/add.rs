//! Passes that are added: of a node kind with the settings that it requires, or as a use of a subgraph.
//!
//! The settings are those of a pass of the same kind, where the pipeline has one. Else each is as the schema says it
//! can be: the first word, a number, the first resource. What is added so parses, and its diagnostics say what it
//! lacks.

use std::path::{Component, Path};

use serde_json::{Map, Value as Json};

use super::draft::position;
use super::error::{ChangeError, Changes};
use super::graph::{Graph, folder, kind_name, one};
use crate::assist::rules::Rules;
use crate::graph::document::Signs;
use crate::graph::edit::Item;
use crate::graph::language::node_kind;
use crate::graph::model::DeclarationKind;

/// The shader template for a new pass, by node kind. Used if the pipeline has no pass of the kind to copy from.
const SHADERS: [(&str, &str); 1] = [("fullscreen", "gradient.wgsl.jinja")];

impl Graph<'_, '_> {
    pub(super) fn add(&self, kind: &str, after: Option<&str>, inputs: Option<&[String]>) -> Changes {
        let own = *self.context.composed.files.first().ok_or(ChangeError::Gone)?;
        let (file, mut draft) = self.draft(own)?;
        let stem = Path::new(kind).file_stem().and_then(|stem| stem.to_str()).unwrap_or("pass");
        let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let stem: String = stem.chars().map(|c| if is_of_name(c) { c } else { '_' }).collect();
        let name = self.free_name(&stem);
        let uses = |name: &str, inputs: &mut dyn Iterator<Item = &str>| {
            let with: Map<String, Json> =
                inputs.map(|input| (input.to_owned(), self.resource(input))).collect();
            let mut pass: Map<String, Json> = [("use".to_owned(), Json::from(name))].into_iter().collect();
            if !with.is_empty() {
                pass.insert("with".to_owned(), with.into());
            }
            Json::from(pass)
        };
        let subgraph = self.context.model.find(DeclarationKind::Subgraph, kind);
        let pass = match (self.context.loaded.registry().get(kind), subgraph, inputs) {
            (Some(_), ..) => {
                Json::Object([(kind.to_owned(), self.settings(kind, &name))].into_iter().collect())
            }
            (None, Some(id), _) => {
                let of = |kind| {
                    move |one: &crate::graph::model::Declaration| one.kind == kind && one.owner == Some(id)
                };
                let is_input = of(DeclarationKind::Input);
                let inputs = self.context.model.declarations().filter(|(_, one)| is_input(one));
                uses(kind, &mut inputs.map(|(_, one)| one.name.as_str()))
            }
            (None, None, Some(inputs)) => {
                let path = if self.is_bundled(kind) {
                    kind.to_owned()
                } else {
                    relative(&folder(Path::new(&file)), Path::new(kind))
                };
                uses(&path, &mut inputs.iter().map(String::as_str))
            }
            _ => return Err(ChangeError::UnknownKind(kind.to_owned())),
        };
        let root = draft.root();
        let Some(passes) = root.get("passes") else {
            draft.put(&["passes", &name], &pass)?;
            return Ok(one(file, draft));
        };
        let count = passes.entries().ok_or(ChangeError::Gone)?.len();
        let behind = after.map(|after| self.pass(after)).transpose()?;
        let behind = behind.and_then(|(id, _)| position(passes, self.name(id)));
        draft.insert(&["passes"], behind.map_or(count, |at| at + 1), &Item::member(name, pass))?;
        Ok(one(file, draft))
    }

    /// Returns a name that no declaration has: `stem`, or else `stem` with a number from 2 on, such as `blur_2`.
    pub(super) fn free_name(&self, stem: &str) -> String {
        let is_taken = |name: &str| self.context.model.declarations().any(|(_, one)| one.name == name);
        let numbered = (2_u32..).map(|number| format!("{stem}_{number}"));
        let mut names = std::iter::once(stem.to_owned()).chain(numbered);
        names.find(|name| !is_taken(name)).unwrap_or_default()
    }

    /// Returns a reference to the resource with this name, or else to the first resource of the pipeline.
    fn resource(&self, name: &str) -> Json {
        let resources = || {
            let all = self.context.model.declarations().map(|(_, one)| one);
            all.filter(|one| one.owner.is_none() && one.kind == DeclarationKind::Resource)
        };
        let found = resources().find(|one| one.name == name).or_else(|| resources().next());
        Json::from(format!("&{}", found.map_or(name, |one| one.name.as_str())))
    }

    /// Returns the required settings for a new pass of a node kind. Copies them from a pass of the same kind, or fills
    /// in placeholders.
    fn settings(&self, kind: &str, name: &str) -> Json {
        let schema = self.context.schema;
        let whole =
            schema.pointer("/$defs/WholePass/else/properties").and_then(|all| all.get(kind)?.get("$ref"));
        let whole = whole.and_then(Json::as_str).and_then(|target| schema.pointer(target.strip_prefix('#')?));
        let required = whole.and_then(|whole| whole.get("required")?.as_array());
        let required = required.into_iter().flatten().filter_map(Json::as_str);
        let shown = self.context.composed.document.root.entries_of("passes").iter();
        let shown =
            shown.filter(|pass| kind_name(&pass.value) == Some(kind)).find_map(|pass| node_kind(&pass.value));
        let rules = Rules::of(schema).below(["passes", name, kind]);
        let setting = |key: &str| match shown.and_then(|shown| shown.value.get(key)) {
            Some(value) if key != "to" || value.text().is_none() => value.to_json(),
            _ => self.placeholder(kind, name, key, &rules.clone().below([key])),
        };
        required.map(|key| (key.to_owned(), setting(key))).collect::<Map<_, _>>().into()
    }

    fn placeholder(&self, kind: &str, name: &str, key: &str, rules: &Rules<'_>) -> Json {
        let shader = SHADERS.iter().find(|(of, _)| *of == kind).map_or("", |(_, shader)| shader);
        let signs: Vec<Signs> = rules.signs().collect();
        let words = rules.words();
        match key {
            "shader" => return shader.into(),
            // Published data is named after the pass.
            "to" if signs.contains(&Signs::Reference) => return format!("&{name}").into(),
            _ => {}
        }
        if signs.contains(&Signs::Reference) {
            return self.resource(name);
        }
        if let Some((word, _)) = words.first() {
            return (*word).into();
        }
        if rules.takes("object") {
            let inner = rules.keys();
            let main = inner.iter().find(|(_, rules)| rules.signs().any(|sign| sign == Signs::Reference));
            let main = main.map(|(key, _)| ((*key).to_owned(), self.resource(name)));
            return main.into_iter().collect::<Map<_, _>>().into();
        }
        match () {
            () if signs.contains(&Signs::Expression) || rules.takes("number") => 1.into(),
            () if rules.takes("boolean") => false.into(),
            () if rules.takes("array") => Json::Array(Vec::new()),
            () => "".into(),
        }
    }
}

/// Returns a path relative to a folder, with `/` as separator.
fn relative(folder: &Path, path: &Path) -> String {
    let parts = |path: &Path| -> Vec<String> {
        let normal = path.components().filter(|part| *part != Component::CurDir);
        normal.map(|part| part.as_os_str().to_string_lossy().into_owned()).collect()
    };
    let (from, to) = (parts(folder), parts(path));
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n("..".to_owned(), from.len() - shared);
    up.chain(to[shared..].iter().cloned()).collect::<Vec<_>>().join("/")
}
