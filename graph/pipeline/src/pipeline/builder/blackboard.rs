//! Blackboard data: published by one pass under a name, read by others.

use crate::access::{SubresourceRange, Version};
use crate::data::{DataShape, ValueType};
use crate::pipeline::builder::PassBuilder;
use crate::pipeline::resource::ResourceKind;
use crate::pipeline::settings::evaluate::Evaluate;
use crate::pipeline::state::shared::Expected;
use crate::work::Subresource;
use umbragraph_text::diagnostic::{Diagnostic, codes, list_of};
use umbragraph_text::language::Ref;

impl PassBuilder<'_> {
    /// Declares the blackboard data that the pass publishes under the name `to`; returns `None` after a diagnostic.
    pub fn publish(&mut self, to: &Ref, pointer: &str, shape: DataShape) -> Option<Subresource> {
        let place = self.place(pointer);
        let at = self.absolute(pointer);
        let name = &self.outside(to, pointer)?.resource;
        let handle = self.shared.intern_data(name, place, &at);
        let resource = &mut self.shared.resources[handle.index()];
        let (code, message, there, help) = match &mut resource.kind {
            ResourceKind::Data(published @ None) => {
                *published = Some(shape);
                resource.place = place;
                resource.pointer = at;
                return Some(self.subresource(handle, SubresourceRange::WHOLE, Version::Newest, pointer));
            }
            ResourceKind::Data(Some(_)) => {
                let message = format!("the data \"{name}\" is published by two passes");
                let help = "give one of the two another name";
                (codes::PUBLISHED_TWICE, message, "it is published here too", help)
            }
            _ => {
                let message = format!("\"{name}\" is {}, not blackboard data", resource.kind_name());
                let help = "publish under a name that no texture or buffer has";
                (codes::WRONG_RESOURCE, message, "it is declared here", help)
            }
        };
        let diagnostic = Diagnostic::error(code, place, message).related(resource.place, there);
        self.shared.diagnostics.push(diagnostic.help(help).pointer(at));
        None
    }

    /// Declares that the pass reads blackboard data that another pass publishes; returns `None` after a diagnostic.
    pub fn data(&mut self, reference: &Ref, pointer: &str) -> Option<Subresource> {
        let place = self.place(pointer);
        let at = self.absolute(pointer);
        let name = &self.outside(reference, pointer)?.resource;
        let handle = self.shared.intern_data(name, place, &at);
        let resource = &self.shared.resources[handle.index()];
        if matches!(resource.kind, ResourceKind::Broken) {
            return None;
        }
        if !matches!(resource.kind, ResourceKind::Data(_)) {
            let message =
                format!("\"{name}\" is {}, but blackboard data is wanted here", resource.kind_name());
            let published = self.shared.resources.iter();
            let published = published.filter(|one| matches!(one.kind, ResourceKind::Data(Some(_))));
            let names: Vec<String> = published.map(|one| format!("\"&{}\"", one.name)).collect();
            let help = match names[..] {
                [] => "name what a CPU pass publishes, such as a camera".to_owned(),
                _ => format!("the passes before publish {}", list_of(names)),
            };
            return self.reject(codes::WRONG_RESOURCE, pointer, message, help);
        }
        Some(self.subresource(handle, SubresourceRange::WHOLE, Version::Newest, pointer))
    }

    /// Declares that the pass reads blackboard data that must publish certain values. For an array, the type of the
    /// elements is compared, but not their number. Returns `None` after a diagnostic.
    pub fn data_with(
        &mut self,
        reference: &Ref,
        pointer: &str,
        values: &[(&str, ValueType)],
    ) -> Option<Subresource> {
        let data = self.data(reference, pointer)?;
        let values = values.iter().map(|(name, value_type)| ((*name).to_owned(), *value_type)).collect();
        let (place, pointer) = (self.place(pointer), self.absolute(pointer));
        self.shared.expected.push(Expected { resource: data.resource, values, place, pointer });
        Some(data)
    }
}
