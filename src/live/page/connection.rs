//! Connections: so many at once, one request each, and little kept for a
//! viewer who does not read.

use std::convert::Infallible;
use std::io;
use std::net::TcpListener;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use futures_util::future::{Either, select};
use http_body_util::{Full, StreamBody, combinators::UnsyncBoxBody};
use hyper::body::{Bytes, Incoming};
use hyper::header::{self, HeaderName, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;
use tokio::sync::Semaphore;
use tokio::task::JoinSet;

use super::request::Answer;
use super::{Shared, viewer};

type Body = UnsyncBoxBody<Bytes, Infallible>;

/// Connections at once; more wait their turn.
const CONNECTIONS: usize = 64;
/// How long a browser may take to say what it wants.
const PATIENCE: Duration = Duration::from_secs(5);
/// How long the last update may take to arrive.
const GOODBYE: Duration = Duration::from_millis(300);
/// What is kept for a viewer who does not read, in here and in the kernel:
/// what is old is worth nothing to them.
const KEPT_BYTES: usize = 16 * 1024;

/// Serves until the last update is out.
pub(super) async fn serve(listener: TcpListener, shared: Arc<Shared>) {
    let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
    let places = Arc::new(Semaphore::new(CONNECTIONS));
    let mut connections = JoinSet::new();
    let mut pulse = shared.pulse.subscribe();
    let mut last_update = pin!(pulse.wait_for(|pulse| pulse.is_last));
    loop {
        let place = Arc::clone(&places).acquire_owned();
        let accepted = async { (place.await, listener.accept().await) };
        match select(&mut last_update, pin!(accepted)).await {
            Either::Left(_) => break,
            Either::Right(((place, Ok((stream, _))), _)) => {
                let connection = connect(stream, Arc::clone(&shared));
                connections.spawn(async move {
                    // Who hangs up half-way is no news to anybody.
                    let _ = connection.await;
                    drop(place);
                });
            }
            // Out of file descriptors, most likely: not for ever.
            Either::Right(((_, Err(_)), _)) => tokio::time::sleep(GOODBYE).await,
        }
        while connections.try_join_next().is_some() {}
    }
    let _ = tokio::time::timeout(GOODBYE, async { while connections.join_next().await.is_some() {} }).await;
}

async fn connect(stream: TcpStream, shared: Arc<Shared>) -> io::Result<()> {
    stream.set_nodelay(true)?;
    rustix::net::sockopt::set_socket_send_buffer_size(&stream, KEPT_BYTES)?;
    let answer = service_fn(|request| std::future::ready(Ok::<_, Infallible>(answer(&request, &shared))));
    http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(PATIENCE)
        .keep_alive(false)
        .max_buf_size(KEPT_BYTES)
        .serve_connection(TokioIo::new(stream), answer)
        .await
        .map_err(io::Error::other)
}

fn answer(request: &Request<Incoming>, shared: &Arc<Shared>) -> Response<Body> {
    let (content_type, body) = match Answer::to(request.method(), request.uri().path(), request.headers()) {
        Answer::Document => ("text/html; charset=utf-8", whole(&shared.document.html)),
        Answer::Updates => match viewer::updates(shared) {
            Some(updates) => ("text/event-stream", UnsyncBoxBody::new(StreamBody::new(updates))),
            None => return refusal(StatusCode::SERVICE_UNAVAILABLE, "as many look on as may\n", shared),
        },
        Answer::Refusal(status, text) => return refusal(status, text, shared),
    };
    response(StatusCode::OK, content_type, body, shared)
}

fn refusal(status: StatusCode, text: &str, shared: &Shared) -> Response<Body> {
    let mut response = response(status, "text/plain; charset=utf-8", whole(text), shared);
    if status == StatusCode::METHOD_NOT_ALLOWED {
        response.headers_mut().insert(header::ALLOW, HeaderValue::from_static("GET"));
    }
    response
}

fn response(status: StatusCode, content_type: &'static str, body: Body, shared: &Shared) -> Response<Body> {
    let mut response = Response::new(body);
    *response.status_mut() = status;
    let fixed = [
        (header::CONTENT_TYPE, content_type),
        (header::CACHE_CONTROL, "no-store"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ];
    let headers = response.headers_mut();
    headers.extend(fixed.map(|(name, value)| (name, HeaderValue::from_static(value))));
    let policy = HeaderValue::from_str(&shared.document.policy).expect("a policy is plain text");
    headers.insert(header::CONTENT_SECURITY_POLICY, policy);
    response
}

fn whole(text: &str) -> Body {
    UnsyncBoxBody::new(Full::from(text.to_owned()))
}
