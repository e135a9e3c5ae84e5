"""AgentSpeak as a language: terms, programs, and how they are read and written."""
