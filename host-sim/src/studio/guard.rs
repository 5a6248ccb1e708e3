//! Checks of a connection: the page must have the token, and must come from this server.
//!
//! The token excludes other users and programs of the same machine. The origin excludes pages of
//! other sites in the same browser: the browser sets it, and no page can change it. The host
//! excludes a site whose name resolves to this machine (DNS rebinding): such a page would have the
//! right origin under its own name.

use std::fmt::Write;
use std::net::{IpAddr, SocketAddr};

use files::error::Error;

/// Length of a token, bytes: 128 bits cannot be guessed.
const BYTES: usize = 16;

/// The secret in the address of the page.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token(..)")
    }
}

impl Token {
    /// Makes a token from the system's random numbers.
    ///
    /// # Errors
    /// Returns an error if the system provides none.
    pub fn random() -> Result<Self, Error> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes)
            .map_err(|error| Error::Input(format!("studio: no random numbers: {error}")))?;
        Ok(Self(bytes.iter().fold(String::new(), |mut text, byte| {
            // Writing to a string does not fail.
            let _ = write!(text, "{byte:02x}");
            text
        })))
    }

    /// Returns the token as text.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Returns whether a text is this token. The time of the comparison does not depend on where
    /// the two differ.
    pub fn is(&self, given: &str) -> bool {
        let differs = self.0.bytes().zip(given.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
        self.0.len() == given.len() && differs == 0
    }
}

/// Returns whether a `Host` header is the address of this server. The only accepted name is
/// `localhost`.
pub fn is_host(host: &str, bound: SocketAddr) -> bool {
    let (name, port) = match host.parse::<SocketAddr>() {
        Ok(address) => (address.ip(), address.port()),
        Err(_) => match host.split_once(':') {
            Some(("localhost", port)) => match port.parse() {
                Ok(port) => (IpAddr::from([127, 0, 0, 1]), port),
                Err(_) => return false,
            },
            _ => return false,
        },
    };
    let same = name == bound.ip() || name.is_loopback() && bound.ip().is_loopback();
    port == bound.port() && (same || bound.ip().is_unspecified())
}

/// Returns whether an `Origin` header is that of a page of this server, which the browser has
/// reached by `host`.
pub fn is_origin(origin: &str, host: &str) -> bool {
    origin.strip_prefix("http://") == Some(host)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_that_token_only() {
        let token = Token::random().unwrap();
        assert_eq!(token.text().len(), 32);
        assert_ne!(token, Token::random().unwrap());
        assert!(token.is(token.text()));
        let mut wrong = token.text().to_owned();
        let last = wrong.pop().unwrap();
        assert!(!token.is(&wrong) && !token.is(""), "a part of it");
        wrong.push(if last == '0' { '1' } else { '0' });
        assert!(!token.is(&wrong));
        assert!(!token.is(&format!("{}0", token.text())), "more than it");
    }

    #[test]
    fn a_host_is_this_server_by_its_address_and_not_by_any_other_name() {
        let local = "127.0.0.1:8420".parse().unwrap();
        for good in ["127.0.0.1:8420", "localhost:8420", "[::1]:8420"] {
            assert!(is_host(good, local), "{good}");
        }
        for bad in ["127.0.0.1:80", "evil.example:8420", "10.0.0.1:8420", "127.0.0.1", "", ":"] {
            assert!(!is_host(bad, local), "{bad}");
        }
        let all = "0.0.0.0:8420".parse().unwrap();
        assert!(is_host("10.0.0.1:8420", all) && !is_host("evil.example:8420", all));
    }

    #[test]
    fn an_origin_is_this_server_only() {
        assert!(is_origin("http://127.0.0.1:8420", "127.0.0.1:8420"));
        for bad in ["http://evil.example", "https://127.0.0.1:8420", "null", ""] {
            assert!(!is_origin(bad, "127.0.0.1:8420"), "{bad}");
        }
    }
}
