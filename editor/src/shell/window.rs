//! The window: scene in the middle, panels around it, redrawn while something moves.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bevy::log::{Level, LogPlugin};
use bevy::prelude::*;
use bevy::render::render_resource::PipelineCache;
use bevy::render::{Render, RenderApp, RenderSystems};
use bevy::window::{PrimaryWindow, RequestRedraw, WindowEvent, WindowResolution};
use bevy::winit::{UpdateMode, WinitSettings};
use bevy_egui::{EguiContexts, EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass};
use sheetwork::scene::Scene;

use super::stage::{self, Quality, SceneCamera};
use super::{Editor, keyboard, probe, scenery};
use crate::cli::Arguments;
use crate::persistence::{self, Persistence};
use crate::playback::is_recording;
use crate::session::Session;

/// Maximum wait for the first complete frame before playback starts.
const MAX_WAIT: Duration = Duration::from_secs(20);

/// Whether a frame has been shown. A failure before that means that no window is possible.
static SHOWN: AtomicBool = AtomicBool::new(false);

/// Whether all pipelines are compiled; set by the render world.
#[derive(Resource, Clone, Default)]
struct Ready(Arc<AtomicBool>);

/// Start time of the program, and optional limit of frames.
#[derive(Resource)]
struct StartupState {
    start: Instant,
    frames: Option<u32>,
    /// Whether playback does not start by itself.
    paused: bool,
    seen: u32,
    /// Whether the first complete frame was shown, which ends the wait.
    begun: bool,
}

/// Open the window on `scene` of `file`, and run until it is closed.
///
/// # Errors
/// The reason why no window could be opened, as part of a sentence.
pub fn run(arguments: &Arguments, scene: &Scene, file: &Path) -> Result<ExitCode, String> {
    let start = Instant::now();
    let adapter = probe::adapter()?;
    let session = if is_recording(file) { Session::open(file) } else { Session::new(scene).map(|s| s.read_from(file)) };
    let mut session = session.map_err(|e| e.to_string())?;
    arguments.compare(&mut session).map_err(|e| e.to_string())?;
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        // Bevy panics without a window; a headless run follows instead of a backtrace.
        if SHOWN.load(Ordering::Relaxed) {
            hook(info);
        }
    }));
    let (frames, paused) = (arguments.frames, arguments.paused || arguments.study.is_some());
    let watch = StartupState { start, frames, paused, seen: 0, begun: false };
    let result = catch_unwind(AssertUnwindSafe(|| app(session, &adapter, arguments, watch).run()));
    match result {
        Ok(AppExit::Success) => Ok(ExitCode::SUCCESS),
        Ok(AppExit::Error(code)) if SHOWN.load(Ordering::Relaxed) => Ok(ExitCode::from(code.get())),
        Err(panic) if SHOWN.load(Ordering::Relaxed) => std::panic::resume_unwind(panic),
        _ => Err("the system refused it".to_owned()),
    }
}

fn app(mut session: Session, adapter: &probe::Adapter, arguments: &Arguments, watch: StartupState) -> App {
    // With software rendering a large window is too slow for mouse interaction.
    let usual = if adapter.software { (1280, 800) } else { (1480, 900) };
    let (width, height) = arguments.size.unwrap_or(usual);
    let window = Window {
        title: format!("{} - Sheetwork", session.world().scene().name),
        resolution: WindowResolution::new(width, height),
        ..default()
    };
    let mut app = App::new();
    let plugins = DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }).set(LogPlugin {
        level: Level::WARN,
        filter: "wgpu=error,naga=warn,bevy_render::renderer=error,bevy_egui=error,egui=error,winit=error".into(),
        ..default()
    });
    app.add_plugins(plugins).add_plugins(EguiPlugin::default());
    app.insert_resource(EguiGlobalSettings { auto_create_primary_context: false, ..default() });
    keyboard::add(&mut app);
    let mut state = arguments.state(&session);
    state.persistence = Persistence::new(persistence::usual_folder());
    session.set_link(true);
    if let Some(file) = session.file().map(Path::to_path_buf) {
        state.persistence.note(&file);
        state.path = file.display().to_string();
    }
    if let Some((copy, scene)) = state.persistence.find_backup() {
        session.note(format!(
            "\"{}\" was not saved when the editor last ended: File, Recover brings it back.",
            scene.name
        ));
        state.left = Some((copy, scene));
    }
    app.insert_resource(Editor { session, state }).insert_resource(watch);
    let quality = if adapter.software { Quality::SOFTWARE } else { Quality::WINDOW };
    scenery::add(&mut app, quality);
    app.add_systems(Startup, cameras);
    app.add_systems(Update, (pass_time, title, pace, rest).chain());
    app.add_systems(EguiPrimaryContextPass, show_panels);
    app.add_systems(Last, (count_frames, keep_work).chain());
    let ready = Ready::default();
    app.insert_resource(ready.clone());
    if let Some(render) = app.get_sub_app_mut(RenderApp) {
        render.insert_resource(ready).add_systems(Render, see_whether_ready.in_set(RenderSystems::Cleanup));
    }
    app
}

/// Spawn a camera for each world that may be displayed, and one above them for the panels.
fn cameras(mut commands: Commands, quality: Res<Quality>) {
    for which in 0..stage::MAX_WORLDS {
        commands.spawn(stage::camera(&quality, which));
    }
    commands.spawn(stage::panel_camera());
}

fn pass_time(mut editor: ResMut<Editor>, time: Res<Time<Real>>) {
    editor.session.frame(time.delta_secs_f64());
    editor.session.exchange();
}

fn show_panels(
    mut contexts: EguiContexts,
    mut editor: ResMut<Editor>,
    mut styled: Local<bool>,
    mut cameras: Query<(&SceneCamera, &mut Camera)>,
    window: Single<&Window, With<PrimaryWindow>>,
    mut exit: MessageWriter<AppExit>,
) -> Result {
    let ctx = contexts.ctx_mut()?;
    editor.draw_panels(ctx, &mut styled);
    if editor.state.quit {
        exit.write(AppExit::Success);
    }
    let whole = UVec2::new(window.physical_width(), window.physical_height());
    let shared = (editor.state.viewport, editor.session.shown_count());
    stage::share(cameras.iter_mut(), shared, (ctx.pixels_per_point(), whole));
    Ok(())
}

fn title(
    editor: Res<Editor>,
    mut window: Single<&mut Window, With<PrimaryWindow>>,
    mut known: Local<Option<(u64, u64)>>,
) {
    let now = (editor.session.generation(), editor.session.document().revision());
    if *known == Some(now) {
        return;
    }
    *known = Some(now);
    let mark = if editor.session.document().is_unsaved() { "● " } else { "" };
    let title = format!("{mark}{} - Sheetwork", editor.session.scene().name);
    if window.title != title {
        window.title = title;
    }
}

/// Redraw continuously while the scene plays, and on events while it is paused.
fn pace(editor: Res<Editor>, mut settings: ResMut<WinitSettings>) {
    let playing = editor.session.playing();
    // Clients of the link need answers while the scene is paused, too.
    let pause = Duration::from_millis(if editor.session.link().is_attached() { 15 } else { 250 });
    let mode = if playing { UpdateMode::Continuous } else { UpdateMode::reactive(pause) };
    if settings.focused_mode != mode {
        settings.focused_mode = mode;
        settings.unfocused_mode = mode;
    }
}

/// Frames drawn after an event: panels need several to settle.
const SETTLE_FRAMES: u32 = 6;

/// Deactivate the cameras while nothing changes: the window keeps its last picture, and an idle
/// editor costs little even with software rendering.
fn rest(
    editor: Res<Editor>,
    watch: Res<StartupState>,
    mut events: MessageReader<WindowEvent>,
    mut redraws: MessageReader<RequestRedraw>,
    mut cameras: Query<(&SceneCamera, &mut Camera)>,
    mut panels: Query<&mut Camera, Without<SceneCamera>>,
    mut last: Local<(u32, Option<[u64; 5]>)>,
) {
    let (left, known) = &mut *last;
    let session = &editor.session;
    let (steps, messages) = (session.world().steps(), session.messages().len() as u64);
    let now = Some([session.generation(), session.revision(), session.document().revision(), steps, messages]);
    let told = events.read().count() + redraws.read().count() > 0;
    if told || session.playing() || !watch.begun || *known != now {
        *left = SETTLE_FRAMES;
    }
    *known = now;
    let active = *left > 0;
    *left = left.saturating_sub(1);
    stage::wake(cameras.iter_mut(), session.shown_count(), active);
    for mut camera in &mut panels {
        if camera.is_active != active {
            camera.is_active = active;
        }
    }
}

/// Back up unsaved work every few seconds, and when the editor ends.
fn keep_work(mut editor: ResMut<Editor>, mut ends: MessageReader<AppExit>) {
    let Editor { session, state } = editor.bypass_change_detection();
    // The scenes of a study are not user work; the session behind it may be.
    let work = state.aside.as_ref().map_or(&*session, |(old, _)| &**old);
    if ends.read().next().is_some() {
        state.persistence.back_up(work);
    } else {
        state.persistence.back_up_periodically(work);
    }
}

/// The first frames are drawn without pipelines that are still being compiled.
fn see_whether_ready(pipelines: Res<PipelineCache>, ready: Res<Ready>) {
    let waiting = pipelines.waiting_pipelines().next().is_some();
    ready.0.store(!waiting, Ordering::Relaxed);
}

/// Start playing when the scene is visible, so that its beginning is not missed.
fn count_frames(
    mut watch: ResMut<StartupState>,
    ready: Res<Ready>,
    mut editor: ResMut<Editor>,
    mut exit: MessageWriter<AppExit>,
) {
    watch.seen += 1;
    if watch.seen == 2 {
        // The first frame reaches the screen while the second is prepared.
        SHOWN.store(true, Ordering::Relaxed);
    }
    let elapsed = watch.start.elapsed();
    let begin = watch.seen > 3 && ready.0.load(Ordering::Relaxed);
    if !watch.begun && (begin || elapsed > MAX_WAIT) {
        watch.begun = true;
        if !watch.paused {
            editor.session.play();
        }
        if watch.frames.is_some() {
            println!("scene seen after {:.2} s, frame {}", elapsed.as_secs_f64(), watch.seen);
            watch.frames = watch.frames.map(|n| n + watch.seen);
        }
    }
    if watch.begun && watch.frames.is_some_and(|n| watch.seen >= n) {
        exit.write(AppExit::Success);
    }
}
