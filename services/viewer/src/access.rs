//! Who may do what: requests come from the page itself, and those that tell of the run or change it
//! have the token of the printed link.
//!
//! A page of another site can make a browser send requests here. It cannot set the header with the
//! token, and its own name stands in `Origin`; a name of its own that it lets point to this machine
//! (DNS rebinding) stands in `Host`. Both are compared with the address that is served.

use std::fs::File;
use std::io::Read;
use subtle::ConstantTimeEq;

/// Header with the token.
pub(crate) const TOKEN_HEADER: &str = "x-zeronav-token";

/// Protocol of the stream. A browser cannot set a header of its own for it, so the token stands
/// beside this name in the list of protocols that the page offers.
pub(crate) const STREAM_PROTOCOL: &str = "zeronav";

/// Random bytes of a token.
const TOKEN_BYTES: usize = 16;

/// What is compared with the headers of requests.
#[derive(Debug, Clone)]
pub(crate) struct Access {
    hosts: [String; 2],
    port: u16,
    /// `None` where everybody can look and nobody can change anything.
    token: Option<String>,
}

impl Access {
    /// Access to the page on this port; without acts when it is only to be looked at.
    ///
    /// # Errors
    /// When the system has no random numbers.
    pub(crate) fn new(port: u16, view_only: bool) -> std::io::Result<Self> {
        let token = (!view_only).then(token).transpose()?;
        Ok(Self::with(port, token))
    }

    /// The access that a link with a token gives; `None` for another text.
    pub(crate) fn of_link(link: &str) -> Option<Self> {
        let (port, token) = link.strip_prefix("http://127.0.0.1:")?.split_once("/#")?;
        let is_token = token.len() == 2 * TOKEN_BYTES
            && token
                .bytes()
                .all(|byte| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte));
        let port = port.parse().ok().filter(|port| *port > 0)?;
        is_token.then(|| Self::with(port, Some(token.to_owned())))
    }

    fn with(port: u16, token: Option<String>) -> Self {
        Self {
            hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")],
            port,
            token,
        }
    }

    /// The port of the page.
    pub(crate) fn port(&self) -> u16 {
        self.port
    }

    /// The address of the page, with the token where there is one.
    pub(crate) fn link(&self) -> String {
        let host = &self.hosts[0];
        match &self.token {
            Some(token) => format!("http://{host}/#{token}"),
            None => format!("http://{host}/"),
        }
    }

    /// Whether a request with these headers comes from the page or from no page at all.
    ///
    /// # Errors
    /// What is wrong, for people.
    pub(crate) fn check(
        &self,
        host: Option<&str>,
        origin: Option<&str>,
    ) -> Result<(), &'static str> {
        let is_own = |name: &str| self.hosts.iter().any(|own| own.eq_ignore_ascii_case(name));
        if !host.is_some_and(is_own) {
            return Err("this address is not served here (Host)");
        }
        let same = |origin: &str| origin.strip_prefix("http://").is_some_and(is_own);
        if !origin.is_none_or(same) {
            return Err("pages of other sites are not answered (Origin)");
        }
        Ok(())
    }

    /// True where everybody can look.
    pub(crate) fn is_open(&self) -> bool {
        self.token.is_none()
    }

    /// Whether a request with this token may look at the run.
    ///
    /// # Errors
    /// What is wrong, for people.
    pub(crate) fn check_look(&self, given: Option<&[u8]>) -> Result<(), &'static str> {
        match self.token {
            Some(_) => self.check_token(given),
            None => Ok(()),
        }
    }

    /// The same for the stream, from the list of protocols that its client offers.
    ///
    /// # Errors
    /// What is wrong, for people.
    pub(crate) fn check_stream(&self, offered: Option<&str>) -> Result<(), &'static str> {
        let mut names = offered.unwrap_or("").split(',').map(str::trim);
        let given = names.find(|name| *name != STREAM_PROTOCOL);
        self.check_look(given.map(str::as_bytes))
    }

    /// Whether a request with this token may change something.
    ///
    /// # Errors
    /// What is wrong, for people.
    pub(crate) fn check_token(&self, given: Option<&[u8]>) -> Result<(), &'static str> {
        let Some(token) = &self.token else {
            return Err("this page is for looking only (--view-only)");
        };
        let given = given.unwrap_or_default();
        if bool::from(token.as_bytes().ct_eq(given)) {
            Ok(())
        } else {
            Err("the token is not that of the printed link")
        }
    }
}

fn token() -> std::io::Result<String> {
    let mut bytes = [0; TOKEN_BYTES];
    File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    let digits = bytes.iter().flat_map(|byte| [byte >> 4, byte & 0xf]);
    Ok(digits
        .filter_map(|digit| char::from_digit(digit.into(), 16))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_own_page_is_answered() {
        let access = Access::new(8090, false).expect("random numbers");
        for host in ["127.0.0.1:8090", "localhost:8090", "LocalHost:8090"] {
            assert_eq!(access.check(Some(host), None), Ok(()));
            let origin = format!("http://{host}");
            assert_eq!(access.check(Some(host), Some(&origin)), Ok(()));
        }
        for host in [
            None,
            Some("evil.example:8090"),
            Some("127.0.0.1"),
            Some("127.0.0.1:8091"),
            Some("127.0.0.1:8090.evil.example"),
            Some(""),
        ] {
            assert!(access.check(host, None).is_err(), "{host:?}");
        }
        for origin in [
            "http://evil.example",
            "https://127.0.0.1:8090",
            "http://127.0.0.1",
            "null",
            "http://127.0.0.1:8091",
        ] {
            let checked = access.check(Some("127.0.0.1:8090"), Some(origin));
            assert!(checked.is_err(), "{origin}");
        }
    }

    #[test]
    fn a_link_gives_the_access_that_printed_it() {
        let access = Access::new(8090, false).expect("random numbers");
        let again = Access::of_link(&access.link()).expect("a link");
        assert_eq!(again.link(), access.link());
        assert_eq!(again.port(), 8090);
        let token = access.token.expect("a token");
        for wrong in [
            String::new(),
            "http://127.0.0.1:8090/".to_owned(),
            format!("http://127.0.0.1:0/#{token}"),
            format!("http://127.0.0.1:65536/#{token}"),
            format!("http://127.0.0.1:8090/#{token}0"),
            format!("http://127.0.0.1:8090/#{}", token.to_uppercase() + "A"),
            format!("http://evil.example:8090/#{token}"),
        ] {
            assert!(Access::of_link(&wrong).is_none(), "{wrong}");
        }
    }

    #[test]
    fn tokens_are_random_and_compared_whole() {
        let access = Access::new(8090, false).expect("random numbers");
        let other = Access::new(8090, false).expect("random numbers");
        assert_ne!(access.token, other.token);
        let token = access.token.clone().expect("a token");
        assert_eq!(token.len(), 2 * TOKEN_BYTES);
        assert_eq!(access.link(), format!("http://127.0.0.1:8090/#{token}"));
        assert_eq!(access.check_token(Some(token.as_bytes())), Ok(()));
        assert!(access.check_token(Some(&token.as_bytes()[1..])).is_err());
        assert!(access.check_token(Some(b"")).is_err());
        assert!(access.check_token(None).is_err());
        assert_eq!(access.check_look(Some(token.as_bytes())), Ok(()));
        assert!(access.check_look(Some(b"")).is_err() && access.check_look(None).is_err());
        assert_eq!(
            access.check_stream(Some(&format!("zeronav, {token}"))),
            Ok(())
        );
        for offered in [
            None,
            Some(""),
            Some("zeronav"),
            Some("zeronav, 0"),
            Some("zeronav,0,1"),
        ] {
            assert!(access.check_stream(offered).is_err(), "{offered:?}");
        }
        let looking = Access::new(8090, true).expect("random numbers");
        assert_eq!(looking.check_look(None), Ok(()));
        assert_eq!(looking.check_stream(None), Ok(()));
        assert_eq!(looking.link(), "http://127.0.0.1:8090/");
        assert!(looking.check_token(Some(b"")).is_err());
        assert!(looking.check_token(None).is_err());
    }
}
