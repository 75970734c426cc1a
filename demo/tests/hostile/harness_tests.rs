//! The harness catches what it is for: each of these cases is a bad loader.
