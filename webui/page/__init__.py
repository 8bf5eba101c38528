"""The state of a page: session, documents, drafts, what was analysed and checked."""
