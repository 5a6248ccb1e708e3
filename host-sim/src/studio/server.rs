//! The HTTP around the connections: who is let in, and what the page is made of.

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
use super::desk::Shared;
use super::forecaster::{self, Wishes};
use super::guard::{Token, is_host, is_origin};
use super::listener::Bounded;
use super::refusals::{Refusals, at_the_terminal};
use super::request::LARGEST;
use super::socket::{Desk, serve};
use super::tuner::Tuner;
use super::worker::{self, About};
use crate::device::wire::Wire;
use crate::error::Error;

/// The largest number of pages.
const PAGES: usize = 16;

/// How many orders may wait for the device.
const ORDERS: usize = 32;

/// What a studio is made for.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Where it listens.
    pub listen: SocketAddr,
    /// Whose joint a pulled file has.
    pub machine: String,
    /// Whether that is the file of this device. If not, nothing is predicted before a joint
    /// is identified, and no file is compared: nobody has told a joint.
    pub is_its_file: bool,
    /// Whether every tick is sent: the device is simulated, and no wire limits that.
    pub every_tick: bool,
}

/// A studio that runs. It ends when this is dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    token: Token,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
    tuner: Arc<Tuner>,
}

/// What every request of HTTP is judged by.
#[derive(Clone, Debug)]
struct Door {
    desk: Desk,
    token: Token,
    bound: SocketAddr,
    pages: Arc<Semaphore>,
    numbers: Arc<AtomicU64>,
}

impl Server {
    /// Opens the device and begins to listen.
    ///
    /// # Errors
    /// Says that the device does not answer, or that nobody may listen at the address.
    pub fn start<W: Wire>(
        wanted: Wanted,
        open: impl Fn() -> Result<W, Error> + Send + 'static,
    ) -> Result<Self, Error> {
        Self::start_telling(wanted, at_the_terminal, open)
    }

    /// The same, where `refused` is told what is refused in the place of the terminal. It is called
    /// by the server's thread, and must not wait.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn start_telling<W: Wire>(
        wanted: Wanted,
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
        let shared = Arc::new(Shared::default());
        let (orders, waiting) = sync_channel(ORDERS);
        let (ready, is_ready) = sync_channel(1);
        let Wanted { machine, is_its_file, every_tick, .. } = wanted;
        let own = is_its_file.then(|| machine.clone());
        let about = About { machine, is_its_file, every_tick };
        let for_worker = shared.clone();
        std::thread::spawn(move || worker::run(open, &about, &for_worker, &waiting, &ready));
        let wishes = Arc::new(Wishes::default());
        let tuner = Tuner::new(own.clone(), shared.clone());
        let (for_forecaster, known) = (wishes.clone(), shared.clone());
        std::thread::spawn(move || forecaster::run(&for_forecaster, &known, own.as_deref()));
        let gone = || Error::Device("studio: the device's thread has ended".into());
        is_ready.recv().map_err(|_| gone())??;
        let refusals = Arc::new(Refusals::new(refused));
        let door = Door {
            desk: Desk { shared, orders, wishes, tuner: tuner.clone(), refusals },
            token: token.clone(),
            bound: address,
            pages: Arc::new(Semaphore::new(PAGES)),
            numbers: Arc::default(),
        };
        let (end, ended) = oneshot::channel();
        let thread = std::thread::spawn(move || {
            runtime.block_on(async {
                let Ok(listener) = TcpListener::from_std(listener) else { return };
                let listener = Bounded::new(listener, door.desk.refusals.clone());
                tokio::select! {
                    // This never ends by itself.
                    _ = axum::serve(listener, routes(door)).into_future() => {}
                    _ = ended => {}
                }
            });
        });
        Ok(Self { address, token, end: Some(end), thread: Some(thread), tuner })
    }

    /// Where it listens.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// The secret of this run.
    pub const fn token(&self) -> &Token {
        &self.token
    }

    /// What a person opens. The token stands behind the `#`, which no browser sends to a server, so
    /// that it is in no log.
    pub fn url(&self) -> String {
        format!("http://{}/#{}", self.address, self.token.text())
    }

    /// Waits for the end of the server, which comes with that of the process.
    pub fn wait(mut self) {
        if let Some(thread) = self.thread.take() {
            // A server that panicked has said so.
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // If none runs, nothing is to be cancelled.
        let _ = self.tuner.cancel();
        // One of them is gone already if the server has ended.
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
        self.desk.refusals.tell(&format!("a connection was refused: {why}"));
        (StatusCode::FORBIDDEN, format!("{why}\n")).into_response()
    }
}

fn text(headers: &HeaderMap, name: header::HeaderName) -> &str {
    headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or("")
}

/// Lets in who has come by the address of this server.
async fn by_address(State(door): State<Door>, request: Request, next: Next) -> Response {
    if !is_host(text(request.headers(), header::HOST), door.bound) {
        let why = "the address of the page is not the one that the studio has printed";
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
        let why = "the token is wrong: open the address that the studio has printed last";
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
