//! The window is opened, or a diagnostic says why it cannot be.

use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use eframe::{NativeOptions, egui};
use umbragraph::diagnostic::{Diagnostic, Place, codes, render};
use umbragraph::low_level::adapter::{Wanted, device_descriptor};
use umbragraph::low_level::camera_path::CameraPath;
use umbragraph::low_level::source::Sources;
use umbragraph::wgpu;

use crate::app::Viewer;
use crate::arguments::Arguments;

umbragraph::low_level::codes! {
    /// The window of the viewer cannot be opened.
    WINDOW = "UG0817", "no window",
        "The viewer needs a display and a graphics adapter that draws to it. On Linux `DISPLAY` or `WAYLAND_DISPLAY` names the display; `xvfb-run` gives a virtual one.";
}

/// Opens the window and runs until it is closed.
///
/// # Errors
/// An error message if a file is missing, the camera path is invalid, or there is no display or graphics adapter.
pub(crate) fn run(arguments: Arguments) -> Result<(), String> {
    missing(&arguments).map_or(Ok(()), |found| Err(text(&found)))?;
    let camera = CameraPath::of(arguments.camera.as_ref()).map_err(|found| text(&found))?;
    let [width, height] = arguments.window.map(|side| side as f32);
    let wanted = Wanted::new(arguments.adapter.as_deref()).map_err(|found| text(&found))?;
    let mut setup = WgpuSetupCreateNew {
        device_descriptor: Arc::new(device_descriptor),
        ..WgpuSetupCreateNew::without_display_handle()
    };
    if let Some(backends) = wanted.backends {
        setup.instance_descriptor.backends = backends;
    }
    // eframe passes a text on, and not the diagnostic.
    let rejected: Arc<Mutex<Option<Diagnostic>>> = Arc::default();
    let told = rejected.clone();
    setup.native_adapter_selector = Some(Arc::new(move |adapters, surface| {
        let draws =
            |adapter: &&wgpu::Adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface));
        wanted.best(adapters.iter().filter(draws).cloned().collect()).map(|(_, adapter)| adapter).map_err(
            |found| {
                let message = found.message.clone();
                *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(found);
                message
            },
        )
    }));
    let options = NativeOptions {
        renderer: eframe::Renderer::Wgpu,
        viewport: egui::ViewportBuilder::default().with_inner_size([width, height]).with_drag_and_drop(true),
        wgpu_options: WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(setup), ..Default::default() },
        ..Default::default()
    };
    let title = format!("{} · umbragraph", arguments.pipeline.display());
    let open = Box::new(move |context: &eframe::CreationContext<'_>| {
        Viewer::new(context, arguments, camera)
            .map(|viewer| Box::new(viewer) as Box<dyn eframe::App>)
            .map_err(Into::into)
    });
    eframe::run_native(&title, options, open).map_err(|error| match error {
        eframe::Error::AppCreation(said) => said.to_string(),
        error => {
            let rejected = rejected.lock().unwrap_or_else(PoisonError::into_inner).take();
            text(&rejected.unwrap_or_else(|| no_window(&error)))
        }
    })
}

/// The diagnostic for a missing file of the command line; `None` if all files exist. A broken file does not prevent the
/// window from opening, since the window shows its diagnostics.
fn missing(arguments: &Arguments) -> Option<Diagnostic> {
    let is_bundled = crate::arguments::is_bundled(&arguments.pipeline);
    let files = [
        (Some(&arguments.pipeline), is_bundled, "the pipeline"),
        (Some(&arguments.scene), false, "--scene names a glTF file"),
        (
            arguments.environment.as_ref(),
            false,
            "--environment names an equirectangular picture, .hdr or .exr",
        ),
    ];
    let imports =
        arguments.imports.iter().map(|one| (Some(&one.path), false, "--import NAME=FILE names a picture"));
    let mut files =
        files.into_iter().chain(imports).filter_map(|(path, is_there, help)| Some((path?, is_there, help)));
    let (path, _, help) = files.find(|(path, is_there, _)| !is_there && !path.is_file())?;
    let name = path.display().to_string();
    let message = format!("the file \"{name}\" is not there");
    Some(
        Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message)
            .help(format!("{help}; check the path")),
    )
}

fn no_window(error: &eframe::Error) -> Diagnostic {
    let (what, help) = match error {
        eframe::Error::Wgpu(_) => (
            "no graphics adapter can draw to a window",
            "install a driver; on Debian and Ubuntu `apt install mesa-vulkan-drivers` gives one in software",
        ),
        _ => (
            "no window can be opened",
            "set DISPLAY or WAYLAND_DISPLAY to a display, or run it under `xvfb-run`",
        ),
    };
    let reason = error.to_string();
    let reason = reason.lines().next().unwrap_or_default();
    // winit's errors begin with the place in its source: "os error at FILE:LINE: reason".
    let reason = match reason.strip_prefix("os error at ").and_then(|rest| rest.split_once(".rs:")) {
        Some((_, rest)) => rest.trim_start_matches(|c: char| c.is_ascii_digit() || c == ':' || c == ' '),
        None => reason,
    };
    Diagnostic::error(WINDOW, Place::Nowhere, format!("{what}: {reason}")).help(help)
}

/// Sets the spacing, colours and input options of the window.
pub(crate) fn style(context: &egui::Context) {
    context.set_theme(egui::Theme::Dark);
    // Frames of a software driver are long: a click may begin in one and end in the next.
    context.options_mut(|options| options.input_options.max_click_duration = 5.0);
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(7.0, 4.0);
        style.spacing.button_padding = egui::vec2(7.0, 2.0);
        style.interaction.tooltip_delay = 0.4;
        if let Some(small) = style.text_styles.get_mut(&egui::TextStyle::Small) {
            small.size = 10.5;
        }
        let visuals = &mut style.visuals;
        visuals.override_text_color = None;
        visuals.hyperlink_color = egui::Color32::from_rgb(125, 180, 250);
        visuals.panel_fill = egui::Color32::from_rgb(30, 32, 37);
        visuals.widgets.noninteractive.fg_stroke.color = egui::Color32::from_gray(205);
        visuals.widgets.inactive.fg_stroke.color = egui::Color32::from_gray(215);
        visuals.faint_bg_color = egui::Color32::from_rgb(36, 38, 44);
    });
}

/// Formats a diagnostic as readable text.
pub(crate) fn text(diagnostic: &Diagnostic) -> String {
    render::human(diagnostic, &Sources::new())
}
