//! The limits of a profile by the names under which pipelines require them.
//!
//! These are the limits of WebGPU for which more is better, with the names of wgpu. Storage buffers also have a limit
//! per stage, since the vertex stage may have fewer of them than the others: none in compatibility mode.

use super::profile::TargetProfile;

macro_rules! named_limits {
    ($($name:ident)*) => {
        impl TargetProfile {
            /// The names that [`TargetProfile::limit`] accepts.
            pub const LIMITS: &'static [&'static str] = &[
                "max_storage_buffers_in_fragment_stage",
                "max_storage_buffers_in_vertex_stage",
                $(stringify!($name)),*
            ];

            /// Returns a limit by its name, such as `max_bind_groups`, in wgpu's unit (a count, texels or bytes).
            /// `None` if the name is unknown.
            pub fn limit(&self, name: &str) -> Option<u64> {
                match name {
                    "max_storage_buffers_in_fragment_stage" => {
                        Some(u64::from(self.limits.max_storage_buffers_per_shader_stage))
                    }
                    "max_storage_buffers_in_vertex_stage" => Some(u64::from(self.vertex_storage_buffers)),
                    $(stringify!($name) => Some(u64::from(self.limits.$name)),)*
                    _ => None,
                }
            }
        }
    };
}

named_limits! {
    max_bind_groups
    max_bindings_per_bind_group
    max_buffer_size
    max_color_attachment_bytes_per_sample
    max_color_attachments
    max_compute_invocations_per_workgroup
    max_compute_workgroup_size_x
    max_compute_workgroup_size_y
    max_compute_workgroup_size_z
    max_compute_workgroup_storage_size
    max_compute_workgroups_per_dimension
    max_inter_stage_shader_variables
    max_sampled_textures_per_shader_stage
    max_samplers_per_shader_stage
    max_storage_buffer_binding_size
    max_storage_buffers_per_shader_stage
    max_storage_textures_per_shader_stage
    max_texture_array_layers
    max_texture_dimension_1d
    max_texture_dimension_2d
    max_texture_dimension_3d
    max_uniform_buffer_binding_size
    max_uniform_buffers_per_shader_stage
    max_vertex_attributes
    max_vertex_buffer_array_stride
    max_vertex_buffers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_a_limit_and_others_have_none() {
        let profile = TargetProfile::webgpu_compat();
        for name in TargetProfile::LIMITS {
            assert!(profile.limit(name).is_some(), "{name}");
        }
        assert_eq!(profile.limit("max_storage_buffers_in_vertex_stage"), Some(0));
        assert_eq!(profile.limit("max_storage_buffers_in_fragment_stage"), Some(4));
        assert_eq!(profile.limit("max_bind_group"), None);
    }
}
