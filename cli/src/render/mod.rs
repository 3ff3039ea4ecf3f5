//! `umbragraph render`: one picture or many frames of a scene, and what textures and buffers hold on the way.

pub(crate) mod capture;
mod drawing;
pub(crate) mod files;
mod report;
mod shown;
mod surroundings;
mod target;
mod timings;

use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, Severity, codes};
use umbragraph::low_level::environment::Environment;
use umbragraph::low_level::import::ImportFiles;

use self::capture::{CaptureFile, LeftOut};
pub(crate) use self::drawing::{Drawing, Given};
use self::files::{Animation, Compression, Format};
use self::report::RunReport;
use self::timings::Timings;
use crate::arguments::RenderArguments;
use crate::device;
use crate::progress::Progress;
use crate::replace::unwritable;
use crate::session::Session;
use crate::streams::{complain, print};

/// Renders a pipeline as the arguments say. Returns `true` if there were no errors.
pub(crate) fn run(mut arguments: RenderArguments) -> bool {
    if arguments.environment.is_some() {
        arguments.choices.settings.feature.push("environment".to_owned());
    }
    let mut session = Session::new(&arguments.choices.files);
    let mut progress = Progress::new();
    let mut report = None;
    let begun = arguments.report.as_deref().map(RunReport::begin).transpose();
    let result = match begun {
        Ok(begun) => {
            report = begun;
            render(&arguments, &mut session, &mut progress, report.as_mut())
        }
        Err(diagnostic) => Err(diagnostic.into()),
    };
    progress.finish();
    let mut said = None;
    match result {
        Ok(text) => said = Some(text),
        Err(diagnostics) => session.diagnostics.extend(diagnostics),
    }
    let mut page = String::new();
    if let Some(report) = report {
        session.arrange();
        match report.write(&session, &arguments) {
            Ok(line) => page = line,
            Err(diagnostic) => session.diagnostics.push(diagnostic),
        }
    }
    let fine = session.report();
    if let Some(said) = said.filter(|_| fine) {
        print(&format!("{said}{page}{}\n", progress.summary()));
        return true;
    }
    complain(&page);
    false
}

/// Renders the frames, writes the files, and returns a description of the written files. `report` gathers what is known
/// of the run, also of one that fails.
///
/// # Errors
/// Diagnostics that the session does not have already.
fn render(
    arguments: &RenderArguments,
    session: &mut Session,
    progress: &mut Progress,
    mut report: Option<&mut RunReport>,
) -> Result<String, Diagnostics> {
    let output = Output::of(arguments)?;
    let path = session.camera(arguments.film.camera.as_ref())?;
    let choices = &arguments.choices;
    let checked = progress.stage("check", || session.check(&arguments.pipeline, choices));
    if let Some(report) = &mut report {
        report.checked(&checked, session);
    }
    let scene = progress.stage("load scene", || session.scene(&arguments.scene))?;
    let plan = checked.plan.as_ref().ok_or_else(Diagnostics::new)?;
    session.diagnostics.extend(umbragraph::scene::filter::left_out(&scene, plan));
    session.ensure_fine(&checked)?;
    let environment = Environment::of(arguments.environment.as_deref(), plan)?;
    let files = ImportFiles::read(&arguments.imports);
    let unusable: Diagnostics = files.errors(plan).into_iter().chain(files.unknown(plan)).collect();
    if !unusable.is_empty() {
        return Err(unusable);
    }
    session.diagnostics.extend(files.empty(plan, environment.is_some()));
    let (mut captures, mut document) = capture::captures(
        plan,
        &arguments.capture,
        arguments.capture_all.as_deref(),
        arguments.report.is_some(),
    )?;
    let graphics = progress.stage("open device", || device::open(arguments.drawn.adapter.as_deref()))?;
    if let Some(report) = &mut report {
        report.device = Some(graphics.name.clone());
    }
    let mut left_out = Vec::new();
    if graphics.is_opengl() {
        let reason = |capture: &CaptureFile, _: &str| {
            capture.has_samples(plan).then(|| "OpenGL copies no textures of several samples".to_owned())
        };
        left_out = capture::leave_out(plan, &mut captures, &mut document, reason)?;
    }
    let without = session.diagnostics.clone();
    let checked = loop {
        let with_captures = if document.imports.is_empty() {
            checked.clone()
        } else {
            session.included = Some(document.text.clone());
            progress.stage("check captures", || session.check(&arguments.pipeline, choices))
        };
        let with_captures = session.check_on(&graphics, with_captures, &arguments.pipeline, choices);
        if session.ensure_fine(&with_captures).is_ok() {
            break with_captures;
        }
        // Such as of contents that a pass discards.
        let errors = std::mem::replace(&mut session.diagnostics, without.clone());
        let about = |_: &CaptureFile, copy: &str| {
            let copy = format!("\"{copy}\"");
            let mut errors = errors.iter().filter(|one| one.severity == Severity::Error);
            let error = errors.find(|error| error.message.contains(&copy))?;
            Some(error.message.replace(&copy, "a capture"))
        };
        let more = capture::leave_out(plan, &mut captures, &mut document, about)?;
        if more.is_empty() {
            session.diagnostics = errors;
            return Err(Diagnostics::new());
        }
        session.included = None;
        left_out.extend(more);
    };
    let options = Session::options(&arguments.choices);
    let given = Given { captures: document.imports.clone(), environment, files };
    let mut drawing = Drawing::new(&graphics, &scene, checked, options, session, given)?;
    drawing.toggles = &arguments.toggles;
    if arguments.timings || arguments.trace.is_some() || report.is_some() {
        drawing.timings = Some(Timings::begin(&mut drawing.executor, &graphics.name));
    }
    let begin = |format| {
        let (size, rate) = (arguments.choices.size, arguments.film.fps);
        Animation::begin(&arguments.out, format, size, output.frames, rate, output.compression)
    };
    let mut animation = output.animation.map(begin).transpose()?;
    if let Some(folder) = arguments.capture_all.as_ref().filter(|_| !captures.is_empty()) {
        std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    }
    progress.begin("draw", u64::from(output.frames));
    for shot in arguments.film.shots(output.frames) {
        let input = drawing.input(&path, shot);
        drawing.frame(&input)?;
        drawing.wait()?;
        if let Some(animation) = &mut animation {
            animation.frame(shot.index, &mut drawing.shown()?)?;
        }
        progress.advance();
    }
    let [width, height] = arguments.choices.size;
    match animation {
        Some(animation) => animation.finish()?,
        None => {
            let write = || -> Result<(), Diagnostic> {
                if output.is_exr {
                    return files::write_exr(&arguments.out, &drawing.numbers()?, false);
                }
                files::write_png(&arguments.out, [width, height], &drawing.shown()?, output.compression)
            };
            progress.stage("write", write)?;
        }
    }
    let frames = if output.frames > 1 { format!("{} frames of ", output.frames) } else { String::new() };
    let mut said = format!("{}: {frames}{width} by {height} on {}\n", arguments.out.display(), graphics.name);
    for LeftOut { capture, reason } in left_out {
        match &mut report {
            Some(report) if capture.is_reported() => report.leave_out(&capture, &reason),
            _ => said.push_str(&capture.left_out(&reason)),
        }
    }
    if let Some(report) = &mut report {
        report.drawn([width, height], &drawing.shown()?, drawing.timings.as_ref());
    }
    progress.begin("write captures", captures.len() as u64);
    for ((capture, captured), by) in captures.iter().zip(drawing.captured()).zip(&document.overwritten) {
        match &mut report {
            Some(report) if capture.is_reported() => report.add(capture, captured),
            _ => said.push_str(&capture.write(&captured?, output.compression, by.as_deref())?),
        }
        progress.advance();
    }
    if let Some(timings) = &drawing.timings {
        if arguments.timings {
            said.push_str(&timings.table());
        }
        if let Some(path) = &arguments.trace {
            said.push_str(&timings.trace(path)?);
        }
    }
    let note = drawing.note().filter(|_| !output.is_exr);
    let notices: Vec<Diagnostic> = drawing.notices().into_iter().chain(note).collect();
    session.diagnostics.extend(notices);
    Ok(said)
}

/// The kind of output that the arguments select.
struct Output {
    /// The format of an animation or of numbered pictures; `None` for a single picture.
    animation: Option<Format>,
    /// Set if the output is a single EXR picture with unconverted numbers.
    is_exr: bool,
    frames: u32,
    compression: Compression,
}

impl Output {
    /// Determines the kind of output from the arguments.
    ///
    /// # Errors
    /// Arguments that exclude each other.
    fn of(arguments: &RenderArguments) -> Result<Self, Diagnostic> {
        let frames = arguments.frames.unwrap_or(1);
        let formats =
            [(".png", Format::Png), (".exr", Format::Exr), (".apng", Format::Apng), (".gif", Format::Gif)];
        let format = files::check("--out", &arguments.out, &formats)?;
        let is_exr = format == Format::Exr;
        if is_exr && (frames > 1 || files::is_numbered(&arguments.out)) {
            let message = format!("--out: \"{}\" is one picture", arguments.out.display());
            return Err(Diagnostic::error(codes::PICTURE, Place::Nowhere, message)
                .help("write frames as .png, .apng or .gif; an .exr is one frame"));
        }
        if frames > 1 && format == Format::Png && !files::is_numbered(&arguments.out) {
            let message =
                format!("--out: \"{}\" is one picture, --frames asks for {frames}", arguments.out.display());
            return Err(Diagnostic::error(codes::PICTURE, Place::Nowhere, message)
                .help("write # where the number of a frame goes, as in frame-####.png, or a file that ends in .apng or .gif"));
        }
        let compression = Compression { fast: arguments.fast };
        let is_picture = is_exr || format == Format::Png;
        let single = frames == 1 && is_picture && !files::is_numbered(&arguments.out);
        Ok(Self { animation: (!single).then_some(format), is_exr, frames, compression })
    }
}
