//! Listener of the server, with a limit on the number of connections.

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::serve::Listener;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::refusals::Refusals;

/// Largest number of connections: a browser opens six, and several pages may be open.
pub const CONNECTIONS: usize = 64;

/// Listener that accepts connections up to the limit, and closes those beyond it.
#[derive(Debug)]
pub struct BoundedListener {
    listener: TcpListener,
    room: Arc<Semaphore>,
    refusals: Arc<Refusals>,
}

impl BoundedListener {
    /// Wraps a listener.
    pub fn new(listener: TcpListener, refusals: Arc<Refusals>) -> Self {
        Self { listener, room: Arc::new(Semaphore::new(CONNECTIONS)), refusals }
    }
}

impl Listener for BoundedListener {
    type Io = CountedConnection;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (CountedConnection, SocketAddr) {
        loop {
            match self.listener.accept().await {
                Ok((stream, address)) => match self.room.clone().try_acquire_owned() {
                    Ok(permit) => return (CountedConnection { stream, _permit: permit }, address),
                    Err(_) => self.refusals.report(&format!(
                        "a connection was closed: {CONNECTIONS} are open already"
                    )),
                },
                // For example, the system has no free file; that passes.
                Err(_) => tokio::time::sleep(Duration::from_millis(100)).await,
            }
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// A connection that frees its place when it ends.
#[derive(Debug)]
pub struct CountedConnection {
    stream: TcpStream,
    _permit: OwnedSemaphorePermit,
}

impl AsyncRead for CountedConnection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, into)
    }
}

impl AsyncWrite for CountedConnection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
