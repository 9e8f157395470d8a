//! Pictures of a scene by the graphics driver, without a window.

use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use bevy::app::PluginsState;
use bevy::camera::RenderTarget;
use bevy::log::{Level, LogPlugin};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use bevy_egui::{EguiContexts, EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass, PrimaryEguiContext, egui};
use bevy_sheetwork::SheetColour;
use sheetwork::InputError;
use sheetwork::scene::Scene;

use super::stage::{self, Quality, SceneCamera};
use super::{Editor, probe, scenery};
use crate::cli::Arguments;
use crate::export::Film;
use crate::panels::{self, Display, EditorState};
use crate::picture::{LARGEST, Look, Picture};
use crate::playback::is_recording;
use crate::session::Session;

/// Default size of a picture, pixels.
pub const PICTURE_SIZE: (u32, u32) = (1280, 800);

/// Frames before the picture: lights, shadows and textures need several.
const WARM_UP_FRAMES: u32 = 4;

/// Maximum time of a picture.
const PICTURE_TIMEOUT: Duration = Duration::from_secs(120);

/// Simulate to the requested times, draw, and write the file: `scenes` side by side, one row per
/// time. Without a graphics driver the software rasteriser draws.
///
/// # Errors
/// When a scene is not valid or the file cannot be written.
pub fn screenshot(
    arguments: &Arguments,
    scenes: &[Scene],
    file: &Path,
    picture: &Path,
) -> Result<ExitCode, InputError> {
    let size = arguments.size.unwrap_or(PICTURE_SIZE);
    let adapter = probe::adapter();
    match &adapter {
        Ok(adapter) => eprintln!("Drawing {} with {}.", file.display(), adapter.name),
        Err(reason) => eprintln!("Drawing {} with the built-in rasteriser: {reason}.", file.display()),
    }
    let mut status = ExitCode::SUCCESS;
    let times = if arguments.at.is_empty() { vec![None] } else { arguments.at.iter().copied().map(Some).collect() };
    let mut rows = Vec::new();
    for time in times {
        let run = |scene: &Scene| simulated(arguments, scene, file, time.unwrap_or(scene.duration));
        rows.push(scenes.iter().map(run).collect::<Result<Vec<_>, _>>()?);
    }
    if rows.iter().flatten().any(|session| session.world().unstable().is_some()) {
        status = ExitCode::from(1);
    }
    let colour = colour_of_all(arguments, rows.iter().flatten());
    let paint = |session: Session| {
        let display = Display { colour, ..arguments.display() };
        let drawn = match &adapter {
            Ok(_) if arguments.with_ui => {
                let mut state = arguments.state(&session);
                state.display.colour = display.for_session(&session).colour;
                draw_panels(session, state, size)
            }
            Ok(_) => draw(session, size, display),
            Err(_) => {
                let camera = crate::camera::Camera::from_world(session.world());
                let look = Look { colour, ..Look::default() };
                Ok(Picture::draw(session.world(), &camera, &look, size))
            }
        };
        drawn.map_err(|problem| InputError::new("", problem).in_file(picture))
    };
    let paint_row = |row: Vec<Session>| row.into_iter().map(paint).collect::<Result<Vec<_>, _>>();
    let rows = rows.into_iter().map(paint_row).collect::<Result<Vec<_>, _>>()?;
    Picture::tiled(&rows).save(picture).map_err(|e| InputError::io(picture, &e))?;
    Ok(status)
}

/// Run the session and write `count` pictures of it, 1/rate apart, to `folder`. Returns whether all
/// sheets stayed stable. Without a graphics driver the software rasteriser draws.
///
/// # Errors
/// When a file cannot be written, or the driver returns no picture.
pub fn sequence(arguments: &Arguments, session: Session, folder: &Path, count: usize) -> Result<bool, InputError> {
    std::fs::create_dir_all(folder).map_err(|e| InputError::io(folder, &e))?;
    let size = arguments.size.unwrap_or(PICTURE_SIZE);
    let state = arguments.state(&session);
    let start = session.world().time();
    let mut drawn = match probe::adapter() {
        Ok(adapter) => {
            eprintln!("Drawing {count} pictures with {}.", adapter.name);
            let made = if arguments.with_ui { Offscreen::editor } else { Offscreen::scene };
            Drawn::Driver(Box::new(made(session, state, size)))
        }
        Err(reason) => {
            eprintln!("Drawing {count} pictures with the built-in rasteriser: {reason}.");
            Drawn::Own(Box::new((Film::from_session(&session)?, state)))
        }
    };
    let progress = indicatif::ProgressBar::new(count as u64);
    for index in 0..count {
        let file = folder.join(format!("frame_{index:04}.png"));
        let picture = drawn
            .picture(size, index as f64 / arguments.rate, start)
            .map_err(|problem| InputError::new("", problem).in_file(&file))?;
        picture.save(&file).map_err(|e| InputError::io(&file, &e))?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(drawn.world().unstable().is_none())
}

/// Renderer of a sequence.
enum Drawn {
    Driver(Box<Offscreen>),
    Own(Box<(Film, EditorState)>),
}

impl Drawn {
    fn world(&mut self) -> &sheetwork::World {
        match self {
            Self::Driver(offscreen) => offscreen.parts().0.world(),
            Self::Own(own) => own.0.world(),
        }
    }

    /// Picture `after` s after the start of the sequence, which is at `start` s.
    fn picture(&mut self, size: (u32, u32), after: f64, start: f64) -> Result<Picture, String> {
        match self {
            Self::Driver(offscreen) => {
                offscreen.parts().0.run_to(start + after);
                // Meshes lag the display by one frame.
                for _ in 0..if after > 0.0 { 1 } else { WARM_UP_FRAMES } {
                    offscreen.frame();
                }
                offscreen.picture()
            }
            Self::Own(own) => {
                let (film, state) = &mut **own;
                let world = film.at(after).map_err(|e| e.to_string())?;
                Ok(Picture::draw(world, &state.camera, &state.display.look(), size))
            }
        }
    }
}

/// Session of `scene`, or of the recording in `file`, at `time` (s), with its variants.
fn simulated(arguments: &Arguments, scene: &Scene, file: &Path, time: f64) -> Result<Session, InputError> {
    let mut session = if is_recording(file) { Session::open(file)? } else { Session::new(scene)? };
    arguments.compare(&mut session)?;
    session.time_stages(arguments.plots);
    session.run(time);
    for message in session.messages() {
        eprintln!("{}", message.text);
    }
    Ok(session)
}

/// Field that colours the sheets of several pictures, with one temperature scale for all.
fn colour_of_all<'a>(arguments: &Arguments, all: impl Iterator<Item = &'a Session>) -> Option<SheetColour> {
    let asked = arguments.sheet_colour();
    if !matches!(asked, None | Some(SheetColour::Temperature)) {
        return asked;
    }
    let mut ends: Option<(f32, f32)> = None;
    for session in all {
        let display = Display { colour: asked, ..arguments.display() }.for_session(session);
        match display.colour.unwrap_or_else(|| SheetColour::of_heat(session.world())) {
            SheetColour::Temperature => {
                let Some(scale) = SheetColour::Temperature.scale(session.world()) else { continue };
                ends = Some(ends.map_or((scale.low, scale.high), |(a, b)| (a.min(scale.low), b.max(scale.high))));
            }
            SheetColour::Plain => {}
            _ => return asked,
        }
    }
    ends.map(|(low, high)| SheetColour::TemperatureBetween { low, high }).or(asked)
}

/// Draw the present state of the session's world by `display`, without panels. Needs a graphics
/// driver ([`probe::adapter`]). `size` in pixels, clamped to 16 to [`LARGEST`].
///
/// # Errors
/// The reason when no picture was returned.
pub fn draw(session: Session, size: (u32, u32), display: Display) -> Result<Picture, String> {
    let state = EditorState { display: display.for_session(&session), ..EditorState::new(&session) };
    Offscreen::scene(session, state, size).warm_picture()
}

/// Draw the whole editor in a window of `size`.
///
/// # Errors
/// The reason when no picture was returned.
pub fn draw_panels(session: Session, state: EditorState, size: (u32, u32)) -> Result<Picture, String> {
    Offscreen::editor(session, state, size).warm_picture()
}

/// Editor without a window, driven frame by frame. Needs a graphics driver ([`probe::adapter`]).
/// Sizes are in pixels, clamped to 16 to [`LARGEST`].
pub struct Offscreen {
    app: App,
    target: Handle<Image>,
    size: (u32, u32),
    /// Supersampling factor.
    factor: u32,
}

impl Offscreen {
    /// The scene without panels.
    pub fn scene(session: Session, state: EditorState, size: (u32, u32)) -> Self {
        let (width, height) = in_range(size);
        let factor = supersampling((width, height));
        let (drawn, mut app) = ((factor * width, factor * height), app(session, state));
        let target = picture_of(&mut app, drawn.0, drawn.1);
        without_panels(&mut app, &target, drawn, factor);
        Self { app, target, size: drawn, factor }
    }

    /// The editor with panels.
    pub fn editor(session: Session, state: EditorState, size: (u32, u32)) -> Self {
        let (size, mut app) = (in_range(size), app(session, state));
        let target = picture_of(&mut app, size.0, size.1);
        with_panels(&mut app, &target, size);
        Self { app, target, size, factor: 1 }
    }

    /// Session and state, which the panels may have changed.
    pub fn parts(&mut self) -> (&mut Session, &mut EditorState) {
        let Editor { session, state } = self.app.world_mut().resource_mut::<Editor>().into_inner();
        (session, state)
    }

    /// Draw a frame.
    pub fn frame(&mut self) {
        self.app.update();
    }

    /// Picture of the next frame.
    ///
    /// # Errors
    /// When no picture was returned.
    pub fn picture(&mut self) -> Result<Picture, String> {
        let picture = captured(&mut self.app, self.target.clone(), self.size)?;
        Ok(if self.factor == 2 { picture.halved() } else { picture })
    }

    /// Picture after the warm-up frames.
    ///
    /// # Errors
    /// When no picture was returned.
    pub fn warm_picture(&mut self) -> Result<Picture, String> {
        (0..WARM_UP_FRAMES).for_each(|_| self.frame());
        self.picture()
    }
}

fn in_range((width, height): (u32, u32)) -> (u32, u32) {
    (width.clamp(16, LARGEST), height.clamp(16, LARGEST))
}

/// Supersampling factor, for finer lines and highlights.
fn supersampling((width, height): (u32, u32)) -> u32 {
    if width.max(height) > LARGEST / 2 { 1 } else { 2 }
}

/// Draw the scene without panels into `target`, which has this number of pixels.
fn without_panels(app: &mut App, target: &Handle<Image>, (width, height): (u32, u32), factor: u32) {
    let whole = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width as f32, height as f32));
    app.world_mut().resource_mut::<Editor>().state.viewport = whole;
    scene_cameras(app, target, (width, height));
    let first = app.world_mut().query::<(Entity, &SceneCamera)>().iter(app.world()).find(|c| c.1.0 == 0).map(|c| c.0);
    if let Some(entity) = first {
        app.world_mut().entity_mut(entity).insert(PrimaryEguiContext);
    }
    app.insert_resource(Supersampling(factor)).add_systems(EguiPrimaryContextPass, show_legend);
    app.add_systems(Update, share_alone);
}

/// Spawn a camera for each world that may be displayed.
fn scene_cameras(app: &mut App, target: &Handle<Image>, (width, height): (u32, u32)) {
    for which in 0..stage::MAX_WORLDS {
        app.world_mut().spawn((stage::camera(&Quality::BEST, which), RenderTarget::Image(target.clone().into())));
    }
    app.insert_resource(PictureSize(UVec2::new(width, height)));
}

/// Draw the whole editor into `target`.
fn with_panels(app: &mut App, target: &Handle<Image>, size: (u32, u32)) {
    scene_cameras(app, target, size);
    app.world_mut().spawn((stage::panel_camera(), RenderTarget::Image(target.clone().into())));
    app.add_systems(EguiPrimaryContextPass, show_panels);
}

/// Create an image as render target.
fn picture_of(app: &mut App, width: u32, height: u32) -> Handle<Image> {
    let mut image = Image::new_target_texture(width, height, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= bevy::render::render_resource::TextureUsages::COPY_SRC;
    app.world_mut().resource_mut::<Assets<Image>>().add(image)
}

/// Read back the next frame of `target`.
fn captured(app: &mut App, target: Handle<Image>, (width, height): (u32, u32)) -> Result<Picture, String> {
    let received: Arc<Mutex<Option<Image>>> = Arc::default();
    let slot = Arc::clone(&received);
    app.world_mut().spawn(Screenshot::image(target)).observe(move |captured: On<ScreenshotCaptured>| {
        *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(captured.image.clone());
    });
    let start = Instant::now();
    while start.elapsed() < PICTURE_TIMEOUT {
        app.update();
        if let Some(image) = received.lock().unwrap_or_else(PoisonError::into_inner).take() {
            return convert(&image, width, height);
        }
    }
    Err("the graphics driver gave no picture back".to_owned())
}

/// App without a window, driven frame by frame.
fn app(session: Session, state: EditorState) -> App {
    let mut app = App::new();
    let plugins = DefaultPlugins
        .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
        .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
        .disable::<WinitPlugin>()
        .disable::<PipelinedRenderingPlugin>();
    // A process has one logger, however many apps it creates.
    static LOGGED: AtomicBool = AtomicBool::new(false);
    let plugins = if LOGGED.swap(true, Ordering::Relaxed) {
        plugins.disable::<LogPlugin>()
    } else {
        plugins.set(LogPlugin { level: Level::ERROR, ..default() })
    };
    app.add_plugins(plugins).add_plugins(EguiPlugin::default());
    app.insert_resource(EguiGlobalSettings { auto_create_primary_context: false, ..default() });
    app.insert_resource(Editor { session, state });
    scenery::add(&mut app, Quality::BEST);
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    app
}

/// Size of the picture, pixels.
#[derive(Resource, Clone, Copy)]
struct PictureSize(UVec2);

fn show_panels(
    mut contexts: EguiContexts,
    mut editor: ResMut<Editor>,
    whole: Res<PictureSize>,
    mut styled: Local<bool>,
    mut cameras: Query<(&SceneCamera, &mut Camera)>,
) -> Result {
    let context = contexts.ctx_mut()?;
    editor.draw_panels(context, &mut styled);
    let shared = (editor.state.viewport, editor.session.shown_count());
    stage::share(cameras.iter_mut(), shared, (context.pixels_per_point(), whole.0));
    stage::wake(cameras.iter_mut(), shared.1, true);
    Ok(())
}

/// Divide the whole picture among the compared worlds.
fn share_alone(editor: Res<Editor>, whole: Res<PictureSize>, mut cameras: Query<(&SceneCamera, &mut Camera)>) {
    let shared = (editor.state.viewport, editor.session.shown_count());
    stage::share(cameras.iter_mut(), shared, (1.0, whole.0));
    stage::wake(cameras.iter_mut(), shared.1, true);
}

/// Supersampling factor of the picture.
#[derive(Resource, Clone, Copy)]
struct Supersampling(u32);

/// Draw the legend of the colours.
fn show_legend(mut contexts: EguiContexts, editor: Res<Editor>, factor: Res<Supersampling>) -> Result {
    let Some(scale) = editor.state.display.scale_of(&editor.session) else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let rect = context.viewport_rect();
    // Text is scaled with the size of the picture.
    let zoom = (rect.width() * context.pixels_per_point() / (1280.0 * factor.0 as f32)).clamp(0.75, 4.0);
    context.set_zoom_factor(zoom * factor.0 as f32);
    panels::legend(&context.layer_painter(egui::LayerId::background()), context.viewport_rect(), &scale);
    Ok(())
}

/// Drop the alpha channel.
fn convert(image: &Image, width: u32, height: u32) -> Result<Picture, String> {
    let data = image.data.as_deref().unwrap_or_default();
    let pixels: Vec<u8> = data.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    if pixels.len() != 3 * width as usize * height as usize {
        return Err(format!("the graphics driver gave {} bytes for {width} x {height} pixels", data.len()));
    }
    Ok(Picture { width, height, pixels })
}
