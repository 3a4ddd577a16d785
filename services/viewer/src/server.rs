//! The server: the page, the stream of what is new, and the acts. Everything it keeps of a client is
//! bounded: connections, headers, bodies, messages, and how long each may take.

use crate::access::{Access, STREAM_PROTOCOL, TOKEN_HEADER};
use crate::act;
use crate::connection::{Connection, STALL_LIMIT};
use crate::feed::{Cursor, Feed};
use crate::page;
use crate::places::{Card, Places, user_of};
use axum::Router;
use axum::body::{Body, Bytes, to_bytes};
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{Extension, Request, State};
use axum::http::header::{self, HeaderMap, HeaderName, HeaderValue};
use axum::http::{StatusCode, Uri};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tokio::time::timeout;
use zeronav_shell::folder::Folder;

/// Clients that are told what is new, at a time.
const WATCHERS_MAX: usize = 32;

/// Acts that wait for launch at a time.
const ACTS_MAX: usize = 4;

/// How long a connection may wait for a request, and a client take to send its headers. Browsers
/// connect before they ask, and on a machine under load long before: who is given up sees
/// `ERR_CONNECTION_RESET` in place of the page. A connection that others need the place of leaves
/// sooner, so that waiting costs nobody anything.
const HEADERS_LIMIT: Duration = Duration::from_secs(300);

/// How long a client may take to send a body.
const BODY_LIMIT: Duration = Duration::from_secs(10);

/// Buffer for the headers of a request. [bytes]
const HEADERS_BYTES_MAX: usize = 16 * 1024;

/// Longest body of a request. [bytes]
const BODY_BYTES_MAX: usize = 32 * 1024;

/// Longest message from a client of the stream; none has anything to say. [bytes]
const MESSAGE_BYTES_MAX: usize = 1024;

/// What the page may do in a browser: load its own files and talk to this server.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
    img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What the handlers share.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) feed: Arc<Feed>,
    pub(crate) access: Access,
    pub(crate) folder: Folder,
    acts: Semaphore,
}

impl Shared {
    pub(crate) fn new(feed: Arc<Feed>, access: Access, folder: Folder) -> Self {
        Self {
            feed,
            access,
            folder,
            acts: Semaphore::new(ACTS_MAX),
        }
    }
}

/// Serves until the end of the process.
pub(crate) async fn serve(listener: TcpListener, shared: Arc<Shared>) {
    let app = router(Arc::clone(&shared));
    let places = Arc::new(Places::default());
    tokio::spawn(watch_run(Arc::clone(&shared)));
    loop {
        let Ok((stream, peer)) = listener.accept().await else {
            // Out of descriptors, most likely: they come back.
            tokio::time::sleep(Duration::from_millis(50)).await;
            continue;
        };
        let user = stream.local_addr().ok().and_then(|own| user_of(peer, own));
        let place = places.take(user);
        let _ = stream.set_nodelay(true);
        let service = TowerToHyperService::new(app.clone().layer(Extension(place.card())));
        let connection = TokioIo::new(Connection::new(stream, place));
        tokio::spawn(async move {
            let mut http = http1::Builder::new();
            http.timer(TokioTimer::new())
                .header_read_timeout(HEADERS_LIMIT)
                .max_buf_size(HEADERS_BYTES_MAX);
            // A client that breaks the protocol or its time limit is left.
            let _ = http
                .serve_connection(connection, service)
                .with_upgrades()
                .await;
        });
    }
}

/// Keeps in the feed what launch says of its run, while somebody listens.
async fn watch_run(shared: Arc<Shared>) {
    loop {
        if shared.feed.watchers() > 0 {
            let of = Arc::clone(&shared);
            let report = tokio::task::spawn_blocking(move || act::report(&of.folder)).await;
            if let Ok(Some(mut report)) = report {
                // Where the run lies is of no use on the page.
                if let Some(report) = report.as_object_mut() {
                    report.retain(|key, _| key != "folder" && key != "domain");
                }
                shared.feed.run(&report);
            }
        }
        tokio::time::sleep(Duration::from_secs(1)).await;
    }
}

fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route(
            "/",
            get(async || file(page::INDEX_HTML, "text/html; charset=utf-8")),
        )
        .route(
            "/style.css",
            get(async || file(page::STYLE_CSS, "text/css; charset=utf-8")),
        )
        .route(
            "/scene.js",
            get(async || file(page::SCENE_JS, "text/javascript; charset=utf-8")),
        )
        .route(
            "/player.js",
            get(async || file(page::PLAYER_JS, "text/javascript; charset=utf-8")),
        )
        .route(
            "/acts.js",
            get(async || file(page::ACTS_JS, "text/javascript; charset=utf-8")),
        )
        .route(
            "/live.js",
            get(async || file(page::LIVE_JS, "text/javascript; charset=utf-8")),
        )
        .route("/stream", get(stream))
        .route("/access", get(access))
        .route("/act", post(act_on))
        .fallback(|uri: Uri| async move {
            (
                StatusCode::NOT_FOUND,
                format!("nothing is served at {}\n", uri.path()),
            )
        })
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), guard))
        .with_state(shared)
}

fn file(text: &'static str, kind: &'static str) -> impl IntoResponse {
    ([(header::CONTENT_TYPE, kind)], text)
}

/// Answers what comes from the page itself only, and says what a browser may do with an answer.
async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let headers = request.headers();
    let checked = shared
        .access
        .check(only(headers, header::HOST), only(headers, header::ORIGIN));
    let mut response = match checked {
        Ok(()) => next.run(request).await,
        Err(why) => forbidden(why),
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (
            HeaderName::from_static("cross-origin-resource-policy"),
            "same-origin",
        ),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// The value of a header that may stand there once; several are as bad as a wrong one.
fn only(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let first = values.next()?;
    if values.next().is_some() {
        return Some("");
    }
    Some(first.to_str().unwrap_or(""))
}

fn forbidden(why: &str) -> Response {
    (StatusCode::FORBIDDEN, format!("{why}\n")).into_response()
}

fn token(headers: &HeaderMap) -> Option<&[u8]> {
    headers.get(TOKEN_HEADER).map(HeaderValue::as_bytes)
}

/// Whether the stream would be told: a browser does not say why it was not.
async fn access(State(shared): State<Arc<Shared>>, headers: HeaderMap) -> Response {
    match shared.access.check_look(token(&headers)) {
        Ok(()) => StatusCode::NO_CONTENT.into_response(),
        Err(why) => forbidden(why),
    }
}

/// An act: a request that launch checks and carries out.
async fn act_on(
    State(shared): State<Arc<Shared>>,
    Extension(card): Extension<Card>,
    headers: HeaderMap,
    body: Body,
) -> Response {
    if let Err(why) = shared.access.check_token(token(&headers)) {
        return forbidden(why);
    }
    card.is_known();
    let said = |status: StatusCode, why: &str| (status, format!("{why}\n")).into_response();
    let body: Bytes = match timeout(BODY_LIMIT, to_bytes(body, BODY_BYTES_MAX)).await {
        Ok(Ok(body)) => body,
        Ok(Err(_)) => return said(StatusCode::PAYLOAD_TOO_LARGE, "the request is too long"),
        Err(_) => return said(StatusCode::REQUEST_TIMEOUT, "the request came too slowly"),
    };
    let line = match act::line_of(&body) {
        Ok(line) => line,
        Err(why) => return said(StatusCode::BAD_REQUEST, &why),
    };
    let Ok(_turn) = shared.acts.try_acquire() else {
        return said(
            StatusCode::SERVICE_UNAVAILABLE,
            "the stack is busy with other requests",
        );
    };
    let of = Arc::clone(&shared);
    let answer = tokio::task::spawn_blocking(move || act::ask(&of.folder, &line)).await;
    match answer {
        Ok(answer) => {
            let kind = [(header::CONTENT_TYPE, "application/json")];
            (kind, answer.to_string()).into_response()
        }
        Err(_) => said(
            StatusCode::INTERNAL_SERVER_ERROR,
            "the request was not made",
        ),
    }
}

/// The stream of what is new.
async fn stream(
    State(shared): State<Arc<Shared>>,
    Extension(card): Extension<Card>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    let offered = only(&headers, header::SEC_WEBSOCKET_PROTOCOL);
    if let Err(why) = shared.access.check_stream(offered) {
        return forbidden(why);
    }
    if !shared.access.is_open() {
        card.is_known();
    }
    let Some(watching) = shared.feed.watch(WATCHERS_MAX) else {
        let why = format!("{WATCHERS_MAX} pages are open already\n");
        return (StatusCode::SERVICE_UNAVAILABLE, why).into_response();
    };
    upgrade
        .protocols([STREAM_PROTOCOL])
        .max_message_size(MESSAGE_BYTES_MAX)
        .max_frame_size(MESSAGE_BYTES_MAX)
        .on_upgrade(async move |mut socket| {
            let _ = tell(&mut socket, &shared.feed).await;
            drop(watching);
        })
}

/// Tells a client what is new, as fast as it takes it, until either end leaves.
async fn tell(socket: &mut WebSocket, feed: &Feed) -> Result<(), axum::Error> {
    let mut news = feed.news();
    let mut cursor = Cursor::default();
    loop {
        news.borrow_and_update();
        while let Some(message) = feed.newer(&mut cursor) {
            let sent = timeout(STALL_LIMIT, socket.send(Message::text(message))).await;
            sent.map_err(axum::Error::new)??;
        }
        if feed.is_over() {
            return socket.send(Message::Close(None)).await;
        }
        tokio::select! {
            changed = news.changed() => if changed.is_err() { return Ok(()) },
            heard = socket.recv() => match heard {
                Some(Ok(_)) => {}
                Some(Err(error)) => return Err(error),
                None => return Ok(()),
            },
        }
    }
}
