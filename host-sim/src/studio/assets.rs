//! Files of the page, which `host-sim/build.rs` builds into the program. The page fetches nothing
//! from other servers.

/// A file of the page.
#[derive(Clone, Copy, Debug)]
pub struct Asset {
    /// Path in the address.
    pub path: &'static str,
    /// Media type.
    pub kind: &'static str,
    /// Contents.
    pub text: &'static str,
}

/// Every file of the page; the first one is the page itself.
pub const ASSETS: [Asset; 4] = [
    Asset {
        path: "/",
        kind: "text/html; charset=utf-8",
        text: include_str!(concat!(env!("STUDIO_PAGE"), "/index.html")),
    },
    Asset {
        path: "/main.js",
        kind: "text/javascript; charset=utf-8",
        text: include_str!(concat!(env!("STUDIO_PAGE"), "/main.js")),
    },
    Asset {
        path: "/page.css",
        kind: "text/css; charset=utf-8",
        text: include_str!(concat!(env!("STUDIO_PAGE"), "/page.css")),
    },
    Asset {
        path: "/faults.md",
        kind: "text/plain; charset=utf-8",
        text: include_str!("../../../docs/reference/faults.md"),
    },
];

/// Content security policy: the page may load only what this server sends.
pub const POLICY: &str = "default-src 'self'; img-src 'self' data: blob:; style-src 'self' \
                          'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'; form-action \
                          'none'";
