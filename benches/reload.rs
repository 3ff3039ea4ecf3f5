//! The time from a saved line of `lit` to the frame that shows it, under `umbra`, while frames run.
//!
//! A line `ratio reload/lit_under_umbra` is the time without wgpu's creation of shader modules and pipelines, divided
//! by what is aimed at (300 ms on two cores). Times are the minimum of several saves; each is another text.

use std::time::{Duration, Instant};

use umbragraph::executor::{imported_texture, read_bytes};
use umbragraph::scene::gpu::SceneResources;
use umbragraph::{Frame, Library, Options, Renderer, Watcher};
use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;

const SAVES: usize = 6;
const AIM: Duration = Duration::from_millis(300);

fn main() {
    let Some(gpu) = gpu::device() else { return };
    let folder = ScratchFolder::new("reload");
    let lit = std::fs::read_to_string("shaders-templates/lit.wgsl.jinja")
        .expect("the workspace is the working folder");
    let save = |text: &str| std::fs::write(folder.join("lit.wgsl.jinja"), text).expect("a file");
    save(&lit);
    let library = Library::new().templates(&*folder);
    let mut watcher = Watcher::new(library, "pipelines/umbra.json").expect("a watcher");
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue);
    let scene = umbragraph::scene::load("examples/scenes/courtyard.glb".as_ref()).expect("a scene");
    let meshes =
        SceneResources::new(&gpu.device, &gpu.queue, &scene, &scene.rest_pose()).expect("a scene that fits");
    let input = scene.frame_input(1.5, 0.0);
    let options = Options::new(96, 64);
    let plan = Library::new().load("pipelines/umbra.json").and_then(|pipeline| pipeline.plan(&options));
    let usages = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    let target = imported_texture(&gpu.device, &plan.expect("a plan"), "target", usages).expect("a texture");
    let mut frame = |watcher: &mut Watcher| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("target", &target)];
        let frame = Frame::new(&input).draws(&meshes).imports(&imports);
        let is_drawn = renderer.record_watched(watcher, &options, &mut encoder, &frame).expect("a record");
        gpu.queue.submit([encoder.finish()]);
        assert!(watcher.error().is_none(), "{:?}", watcher.error());
        is_drawn.then(|| pollster::block_on(read_bytes(&gpu.device, &gpu.queue, &target)).expect("bytes"))
    };
    let before = loop {
        if let Some(picture) = frame(&mut watcher) {
            break picture;
        }
    };
    watcher.take_reload();
    println!("{:>10} {:>10} {:>10} {:>10} {:>10}", "save ms", "notice", "load", "plan", "pipelines");
    let mut best = Duration::MAX;
    for at in 0..SAVES {
        let saved = Instant::now();
        save(&format!("{lit}\nconst SAVE: f32 = {at}.0;\n"));
        let reload = loop {
            frame(&mut watcher);
            if let Some(reload) = watcher.take_reload() {
                break reload;
            }
            std::thread::sleep(Duration::from_millis(1));
        };
        let whole = saved.elapsed();
        let millis = |time: Duration| time.as_secs_f64() * 1e3;
        println!(
            "{:>10.1} {:>10.1} {:>10.1} {:>10.1} {:>10.1}",
            millis(whole),
            millis(reload.changed - saved),
            millis(reload.loaded),
            millis(reload.planned),
            millis(reload.prepared)
        );
        best = best.min(whole.saturating_sub(reload.prepared));
    }
    assert!(frame(&mut watcher) == Some(before), "a constant that nothing reads");
    println!("ratio reload/lit_under_umbra {:.3}", best.as_secs_f64() / AIM.as_secs_f64());
}
