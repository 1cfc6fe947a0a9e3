"""What is learned of logs, as functions: the logs and what is declared of them go in, results come out."""
