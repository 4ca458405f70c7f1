"""A motion that is computed anew while its parameters and its start change, without Python: in WebAssembly or here."""
