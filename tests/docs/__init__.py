"""The pages whose commands are run: what they print is what the program prints."""
