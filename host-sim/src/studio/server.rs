//! HTTP server of the studio: checks of connections, and the files of the page.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread::JoinHandle;

use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Query, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Deserialize;
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, oneshot};

use super::assets::{ASSETS, POLICY};
use super::desk::StudioState;
use super::forecaster::{self, PredictionQueue};
use super::guard::{Token, is_host, is_origin};
use super::listener::BoundedListener;
use super::refusals::{Refusals, at_the_terminal};
use super::request::LARGEST;
use super::socket::{StudioHandles, serve};
use super::tuner::Tuner;
use super::worker::{self, DeviceContext};
use files::error::Error;
use simulator::device::clock::{Clock, ComputerClock};
use simulator::device::wire::Wire;

/// Largest number of pages.
const PAGES: usize = 16;

/// Largest number of requests that wait for the device.
const ORDERS: usize = 32;

/// Options of a studio.
#[derive(Clone, Debug)]
pub struct StudioOptions {
    /// Address to listen at.
    pub listen: SocketAddr,
    /// Machine's file that provides the joint of a pulled file.
    pub machine: String,
    /// Whether `machine` is the file of this device. If not, predictions need an identified joint,
    /// and a comparison needs a file from the page.
    pub is_its_file: bool,
    /// Whether every tick is sent: a simulated device has no wire that limits the rate.
    pub every_tick: bool,
}

/// A running studio. It ends when this is dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    token: Token,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
    tuner: Arc<Tuner>,
}

/// State with which each HTTP request is checked.
#[derive(Clone, Debug)]
struct Door {
    desk: StudioHandles,
    token: Token,
    bound: SocketAddr,
    pages: Arc<Semaphore>,
    numbers: Arc<AtomicU64>,
}

impl Server {
    /// Opens the device and starts to listen.
    ///
    /// # Errors
    /// Returns an error if the device does not answer, or if the address cannot be used.
    pub fn start<W: Wire>(
        wanted: StudioOptions,
        open: impl Fn() -> Result<W, Error> + Send + 'static,
    ) -> Result<Self, Error> {
        Self::start_on(Arc::new(ComputerClock), wanted, at_the_terminal, open)
    }

    /// Starts like [`start`](Self::start) on another clock, and passes refusals to `refused`
    /// instead of the terminal. The server's thread calls `refused`, so it must not block.
    ///
    /// # Errors
    /// Returns the errors of [`start`](Self::start).
    pub fn start_on<W: Wire>(
        clock: Arc<dyn Clock>,
        wanted: StudioOptions,
        refused: impl Fn(&str) + Send + Sync + 'static,
        open: impl Fn() -> Result<W, Error> + Send + 'static,
    ) -> Result<Self, Error> {
        let token = Token::random()?;
        let failed = |error: std::io::Error| {
            Error::Input(format!("studio: cannot listen at {}: {error}", wanted.listen))
        };
        let listener = std::net::TcpListener::bind(wanted.listen).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
        let shared = Arc::new(StudioState::on_clock(clock.clone()));
        let (orders, waiting) = sync_channel(ORDERS);
        let (ready, is_ready) = sync_channel(1);
        let StudioOptions { machine, is_its_file, every_tick, .. } = wanted;
        let own = is_its_file.then(|| machine.clone());
        let about = DeviceContext { machine, is_its_file, every_tick };
        let for_worker = shared.clone();
        std::thread::spawn(move || worker::run(open, &about, &for_worker, &waiting, &ready));
        let wishes = Arc::new(PredictionQueue::default());
        let tuner = Tuner::new(own.clone(), shared.clone());
        let (for_forecaster, known) = (wishes.clone(), shared.clone());
        std::thread::spawn(move || forecaster::run(&for_forecaster, &known, own.as_deref()));
        let gone = || Error::Device("studio: the device's thread has ended".into());
        is_ready.recv().map_err(|_| gone())??;
        let refusals = Arc::new(Refusals::new(clock, refused));
        let door = Door {
            desk: StudioHandles { shared, orders, wishes, tuner: tuner.clone(), refusals },
            token: token.clone(),
            bound: address,
            pages: Arc::new(Semaphore::new(PAGES)),
            numbers: Arc::default(),
        };
        let (end, ended) = oneshot::channel();
        let thread = std::thread::spawn(move || {
            runtime.block_on(async {
                let Ok(listener) = TcpListener::from_std(listener) else { return };
                let listener = BoundedListener::new(listener, door.desk.refusals.clone());
                tokio::select! {
                    // This never ends.
                    _ = axum::serve(listener, routes(door)).into_future() => {}
                    _ = ended => {}
                }
            });
        });
        Ok(Self { address, token, end: Some(end), thread: Some(thread), tuner })
    }

    /// Returns the address at which the server listens.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Returns the token of this run.
    pub const fn token(&self) -> &Token {
        &self.token
    }

    /// Returns the address that the user opens. The token follows the `#`, which no browser sends
    /// to a server, so it is in no log.
    pub fn url(&self) -> String {
        format!("http://{}/#{}", self.address, self.token.text())
    }

    /// Waits until the server ends. It runs until the process ends.
    pub fn wait(mut self) {
        if let Some(thread) = self.thread.take() {
            // A panic of the server was already printed.
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // If no tuning runs, there is nothing to cancel.
        let _ = self.tuner.cancel();
        // If the server has ended, the receiver is gone.
        let _ = self.end.take().map(|end| end.send(()));
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn routes(door: Door) -> Router {
    let mut router = Router::new().route("/link", get(link));
    for asset in ASSETS {
        let headers = [
            (header::CONTENT_TYPE, asset.kind),
            (header::CONTENT_SECURITY_POLICY, POLICY),
            (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
            (header::REFERRER_POLICY, "no-referrer"),
            (header::CACHE_CONTROL, "no-store"),
        ];
        router = router.route(asset.path, get(move || async move { (headers, asset.text) }));
    }
    router.layer(from_fn_with_state(door.clone(), by_address)).with_state(door)
}

impl Door {
    fn refused(&self, why: &'static str) -> Response {
        self.desk.refusals.report(&format!("a connection was refused: {why}"));
        (StatusCode::FORBIDDEN, format!("{why}\n")).into_response()
    }
}

fn text(headers: &HeaderMap, name: header::HeaderName) -> &str {
    headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or("")
}

/// Accepts only requests to the address of this server.
async fn by_address(State(door): State<Door>, request: Request, next: Next) -> Response {
    if !is_host(text(request.headers(), header::HOST), door.bound) {
        let why = "the address of the page is not the one that the studio printed";
        return door.refused(why);
    }
    next.run(request).await
}

#[derive(Debug, Deserialize)]
struct Secret {
    #[serde(default)]
    token: String,
}

async fn link(
    State(door): State<Door>,
    Query(secret): Query<Secret>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    if !is_origin(text(&headers, header::ORIGIN), text(&headers, header::HOST)) {
        return door.refused("the page is of another origin");
    }
    if !door.token.is(&secret.token) {
        let why = "the token is wrong: open the address that the studio printed last";
        return door.refused(why);
    }
    let Ok(permit) = door.pages.clone().try_acquire_owned() else {
        return door.refused("too many pages are open");
    };
    let number = door.numbers.fetch_add(1, Ordering::Relaxed);
    upgrade.max_message_size(LARGEST).max_frame_size(LARGEST).on_upgrade(move |socket| async move {
        serve(socket, number, door.desk).await;
        drop(permit);
    })
}
