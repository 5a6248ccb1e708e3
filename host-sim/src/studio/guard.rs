//! Who may connect: a page that knows the token, and that this server has sent.
//!
//! The token keeps other people and programs of the same machine out. The origin keeps a page of
//! another site out that runs in the same browser: a browser states it, and no page can change it.
//! The host keeps out a site whose name was made to lead to this machine (DNS rebinding): such a
//! page would have the right origin by its own name.

use std::fmt::Write;
use std::net::{IpAddr, SocketAddr};

use crate::error::Error;

/// Bytes of a token: nobody guesses 128 bits.
const BYTES: usize = 16;

/// The secret that stands in the address of the page.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token(..)")
    }
}

impl Token {
    /// Makes a token by the system's random numbers.
    ///
    /// # Errors
    /// Says that the system gives none.
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

    /// The token as it stands in the address.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Tells whether this is the token, in a time that does not depend on where it differs.
    pub fn is(&self, given: &str) -> bool {
        let differs = self.0.bytes().zip(given.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
        self.0.len() == given.len() && differs == 0
    }
}

/// Tells whether a `Host` header names this server by its address. Of names, only `localhost` does.
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

/// Tells whether an `Origin` header is that of a page of this server, which the browser has reached
/// by `host`.
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
    fn a_host_is_this_server_by_its_address_and_no_name_that_somebody_made_up() {
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
