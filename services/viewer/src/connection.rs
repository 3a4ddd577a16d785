//! A connection that has one of a fixed number of places for as long as it is open, whatever
//! protocol it changes to. It fails when it is its turn to leave, and when the other end leaves
//! what it is sent untaken for too long.

use crate::places::Place;
use core::future::Future;
use core::pin::Pin;
use core::task::{Context, Poll};
use std::io::{Error, ErrorKind, Result};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::Sleep;

/// How long a client may leave an answer or a message untaken.
pub(crate) const STALL_LIMIT: Duration = Duration::from_secs(10);

/// See the module's description.
#[derive(Debug)]
pub(crate) struct Connection<S = TcpStream> {
    stream: S,
    place: Place,
    has_to_leave: bool,
    stall_limit: Duration,
    /// Runs while the other end takes nothing.
    stalled: Option<Pin<Box<Sleep>>>,
}

impl<S> Connection<S> {
    pub(crate) fn new(stream: S, place: Place) -> Self {
        Self {
            stream,
            place,
            has_to_leave: false,
            stall_limit: STALL_LIMIT,
            stalled: None,
        }
    }

    /// Fails once the place is another's.
    fn poll_place(&mut self, context: &mut Context<'_>) -> Result<()> {
        self.has_to_leave =
            self.has_to_leave || Pin::new(&mut self.place.leave).poll(context).is_ready();
        if self.has_to_leave {
            return Err(Error::from(ErrorKind::ConnectionAborted));
        }
        Ok(())
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Connection<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        to: &mut ReadBuf<'_>,
    ) -> Poll<Result<()>> {
        self.poll_place(context)?;
        Pin::new(&mut self.stream).poll_read(context, to)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Connection<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<Result<usize>> {
        self.poll_place(context)?;
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        if written.is_ready() {
            self.stalled = None;
            return written;
        }
        let stall_limit = self.stall_limit;
        let limit = || Box::pin(tokio::time::sleep(stall_limit));
        let stalled = self.stalled.get_or_insert_with(limit);
        let over = stalled.as_mut().poll(context);
        over.map(|()| Err(Error::from(ErrorKind::TimedOut)))
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::places::Places;
    use std::sync::Arc;
    use tokio::io::AsyncWriteExt;

    /// Takes nothing, ever.
    struct Deaf;

    impl AsyncWrite for Deaf {
        fn poll_write(self: Pin<&mut Self>, _: &mut Context<'_>, _: &[u8]) -> Poll<Result<usize>> {
            Poll::Pending
        }
        fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<Result<()>> {
            Poll::Ready(Ok(()))
        }
        fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<Result<()>> {
            Poll::Ready(Ok(()))
        }
    }

    /// How writing to a client that takes nothing ends.
    async fn written(place: Place, stall_limit: Duration) -> ErrorKind {
        let mut connection = Connection::new(Deaf, place);
        connection.stall_limit = stall_limit;
        let ended = connection.write_all(b"answer").await;
        ended.expect_err("it cannot be written").kind()
    }

    #[test]
    fn an_answer_that_is_not_taken_ends_the_connection() {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .build()
            .expect("a runtime");
        let places = Arc::new(Places::default());
        let soon = Duration::from_millis(5);
        let ended = runtime.block_on(written(places.take(None), soon));
        assert_eq!(ended, ErrorKind::TimedOut);
        // Sooner, when others need the place.
        let place = places.take(None);
        let _others: Vec<Place> = (0..64).map(|_| places.take(None)).collect();
        let ended = runtime.block_on(written(place, Duration::MAX));
        assert_eq!(ended, ErrorKind::ConnectionAborted);
    }
}
