fn main() -> std::io::Result<()> {
    let proto = "../../../proto";
    tonic_prost_build::configure()
        .build_server(false)
        .build_transport(false) // whose constructor `connect` would have the name of an RPC
        .compile_protos(&[format!("{proto}/stiefel/v1/simulation.proto")], &[proto.to_string()])
}
